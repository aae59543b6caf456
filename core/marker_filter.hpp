// The Kalman filter (15) to (19): keeps both blocks of the state [x_n; x_{n-1}] true to the markers.
#pragma once

#include <span>
#include <vector>

#include "core/modal_basis.hpp"
#include "core/modal_covariance.hpp"
#include "core/model.hpp"

namespace tissued::core {

struct Innovation {
  int markers_used = 0;
  int markers_swapped = 0;  // of them: labels that were taken for each other
  double rms = 0.0;         // mm per axis, before the correction
};

// The covariance depends on which markers are seen and which pads hold, never on the data: when the gain has settled
// for such a pattern it is kept, and a frame costs O(n m) until the pattern changes.
class MarkerFilter {
 public:
  MarkerFilter(const Model& model, const ModalBasis& basis, const FilterOptions& options);

  void reset();
  // Covariance predict (16), then update and correction (17) of x and x_previous from the markers seen. `frames`: how
  // many nominal time steps have passed since the last call. held_pads: their nodes are known, to within kPadNoise.
  Innovation correct(std::span<const Vec3> markers, std::span<const std::uint8_t> seen,
                     std::span<const std::uint8_t> held_pads, int frames, NodeField& x, NodeField& x_previous);
  bool settled() const { return settled_; }
  // mm^2 per axis, of a target's position.
  double target_variance(int target) const;
  // Covariance of the whole state, for tests and studies.
  const ModalCovariance& covariance() const { return covariance_; }
  const ModalBasis& basis() const { return basis_; }

  static constexpr double kPadNoise = 1e-3;  // mm, standard deviation

 private:
  void choose_pattern(std::span<const std::uint8_t> seen, std::span<const std::uint8_t> held_pads);
  void advance_covariance(int frames);
  void settle();
  void apply_modal(NodeField& x, NodeField& x_previous);
  void apply_nodal(NodeField& x, NodeField& x_previous) const;

  const Model& model_;
  ModalBasis basis_;
  double marker_variance_;                          // mm^2
  Eigen::VectorXd transition_;                      // (r) a_j = 1 / (1 + dt^2 lambda_j)
  RowMatrix marker_rows_, pad_rows_, target_rows_;  // modal: C Phi, one row per marker, holdable node, target
  ModalCovariance covariance_, initial_covariance_;

  std::vector<std::uint8_t> pattern_, candidate_;  // markers seen, then pads held
  std::vector<int> used_markers_;
  int rows_used_ = 0;   // markers first, then pad nodes
  RowMatrix observed_;  // (largest m x r)
  Eigen::VectorXd variances_;
  bool settled_ = false;
  RowMatrix last_gain_;                 // (largest m x r), to tell when it has settled
  RowMatrix nodal_now_, nodal_before_;  // (free x markers): the settled gain at the nodes
  std::vector<double> settled_target_variance_;

  std::vector<Eigen::Vector4d> innovation_;                                             // (markers used)
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> modal_now_, modal_before_;  // (r x 4)
};

}  // namespace tissued::core
