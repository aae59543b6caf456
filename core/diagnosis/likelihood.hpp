// How well a prediction fits, with all that is known to be wrong of both: noise, where markers sit, and what the
// discretisation leaves. Per channel, over the frames t of all trials k together,
//   residual ~ N(0, noise^2 I + offset^2 1 1^T + sum_k discretisation_k^2 f_k f_k^T + bend_k^2 g_k g_k^T),
//   f_k(t) = load(t) / peak load,  g_k = 4 f_k (1 - f_k).
// Each channel's covariance is inverted by the Woodbury identity.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "core/diagnosis/session.hpp"

namespace tissued::core {

struct ErrorModel {
  Eigen::VectorXd noise;     // (channels) mm or N
  Eigen::VectorXd offset;    // (channels) standard deviation of a constant over all trials
  RowMatrix discretisation;  // (trials x channels), standard deviation at the trial's peak load
  RowMatrix bend;            // likewise, at half the load, of what is not in proportion to it; empty: none
};

// One trial's prediction against what was seen.
struct TrialResidual {
  int trial = 0;                       // row of ErrorModel::discretisation
  RowMatrix residual;                  // (frames x channels) seen - predicted; NaN where nothing was seen
  std::vector<RowMatrix> derivatives;  // (parameters) of the prediction
  Eigen::VectorXd load;                // (frames) share of the peak load
};

// Least squares in whitened residuals: chi_square, and by the parameters gradient J^T C^-1 r and normal J^T C^-1 J.
struct NormalEquations {
  double chi_square = 0.0;
  int count = 0;  // residuals
  Eigen::VectorXd gradient;
  Eigen::MatrixXd normal;
  Eigen::VectorXd chi_square_of_channel, count_of_channel;
};

// All of them, or all but that of one trial.
std::vector<const TrialResidual*> pointers_to(const std::vector<TrialResidual>& residuals, int but = -1);

NormalEquations normal_equations(const ErrorModel& errors, std::span<const TrialResidual* const> trials);

// Far from the truth noise is no measure of the misfit, and what is allowed for discretisation would be used up to
// hide it: noise raised to what is left, for each kind of channel.
ErrorModel raised(const ErrorModel& errors, const Channels& channels, const NormalEquations& equations);

// What is likely wrong of the prediction besides its numbers, given the residuals.
struct Nuisances {
  Eigen::VectorXd offset;    // (channels) a constant over all trials
  RowMatrix discretisation;  // (trials x channels) at the trial's peak load
  RowMatrix bend;            // (trials x channels) at half of it

  // What they make of a trial's frame at this share of its peak load.
  double of(Eigen::Index trial, Eigen::Index channel, double load) const {
    return offset[channel] + discretisation(trial, channel) * load + bend(trial, channel) * 4.0 * load * (1.0 - load);
  }
};
Nuisances nuisances(const ErrorModel& errors, std::span<const TrialResidual* const> trials);

// Mean square of what is left of the residuals in bins of so many frames, nuisances taken off, in units of what noise
// leaves there: 1 where nothing but noise is left. Of markers (0), targets (1), forces (2); 0 where none was seen.
std::array<double, 3> structure_left(const ErrorModel& errors, const Channels& channels,
                                     std::span<const TrialResidual* const> trials, int bin = 15);

// Standard deviation of the frame-to-frame noise of every channel, from second differences where the pads rest or move
// evenly; `stated` where too little was seen.
Eigen::VectorXd noise_seen(std::span<const RecordedTrial> trials, const Eigen::VectorXd& stated);

}  // namespace tissued::core
