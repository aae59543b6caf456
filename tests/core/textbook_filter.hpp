// The Kalman filter (15) to (19) as a textbook writes it: dense matrices, nodal coordinates, nothing cached. One axis.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/model.hpp"

namespace tissued::core::testing {

class TextbookFilter {
 public:
  // process_size: mm^2; paper: on every node of both blocks; standard: at the markers, when nothing is observed.
  TextbookFilter(const Model& model, NoisePreset preset, double process_size, double marker_variance,
                 double pad_variance);

  // (2 free x 2 free) mm^2, where the next predict starts.
  Eigen::MatrixXd covariance;

  // Where the covariance settles with these rows observed in every frame.
  void settle(const std::vector<std::uint8_t>& seen, const std::vector<std::uint8_t>& held_pads, int frames);
  // One frame; leaves the gain of the rows that were observed, markers first: (2 free x rows).
  void step(const std::vector<std::uint8_t>& seen, const std::vector<std::uint8_t>& held_pads, int frames);
  const Eigen::MatrixXd& gain() const { return gain_; }
  double target_variance(int target) const;
  const Eigen::MatrixXd& transition() const { return transition_; }
  // Mean over the markers of their variance when nothing is ever observed.
  double marker_prior() const;

 private:
  Eigen::RowVectorXd row_of(const MaterialPoint& point) const;

  const Model& model_;
  double marker_variance_, pad_variance_;
  Eigen::Index free_;
  Eigen::MatrixXd transition_, process_, gain_;
};

}  // namespace tissued::core::testing
