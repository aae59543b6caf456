// What markers do that the simulation does not, and what that says about targets: pads slide on the skin that they are
// glued to in the simulation, and the rest is smooth and fades away from the markers.
//
//   b(place) = S(place) slip + r(place),  slip ~ N(0, slip_variance),  r ~ GP(0, variance, kLength)
// with S the elastic answer of the body at rest to moving a pad along the skin. In time b walks with the load: while
// that rests, a marker's noise averages out of it.
#pragma once

#include <span>
#include <vector>

#include "core/model.hpp"
#include "core/rest_compliance.hpp"

namespace tissued::core {

class Discrepancy {
 public:
  // noise_variance: mm^2 per axis, of a marker in one frame.
  Discrepancy(const Model& model, double noise_variance);

  void reset();
  // Other pads hold than before; the compliance knows of them already.
  void hold(const RestCompliance& compliance, std::span<const std::uint8_t> held_pads);
  // One frame. moved: (markers) mm, each marker since the frame before. share: of the load (mm), by which b walks.
  void follow(std::span<const Vec3> innovation, std::span<const int> used, std::span<const double> moved, double share,
              double load, double dt);
  // The simulation will be another one: every marker's b is not known to so many mm^2 more.
  void widen(double variance);
  // Explains the markers' b. mm^2 per axis, of r and of a pad's slip, before any marker is seen.
  void explain(double variance, double slip_variance);

  const Vec3& at_marker(int marker) const { return at_marker_[static_cast<std::size_t>(marker)]; }    // mm
  double uncertainty(int marker) const { return uncertainty_[static_cast<std::size_t>(marker)]; }     // mm^2 per axis
  const Vec3& at_target(int target) const { return at_target_[static_cast<std::size_t>(target)]; }    // mm
  const Mat3& covariance(int target) const { return covariance_[static_cast<std::size_t>(target)]; }  // mm^2
  Vec3 slip(int pad) const;                                                                           // mm
  Vec3 slip_at_marker(int marker) const;                                                              // mm
  double correlation(int marker, int other) const { return kernel_(marker, other); }                  // of r
  // mm per mm: what slips of the pads that hold do to an axis of a marker or, after them, a target.
  const RowMatrix& slip_rows() const { return slip_rows_; }  // (3 (markers + targets) x 3 pads that can hold)
  int slips() const { return slips_; }                       // columns in use

  static constexpr double kLength = 15.0;  // mm

 private:
  void fill_system(double variance);
  void find_slip(double slip_variance);
  void explain_target(int target, double variance);

  int marker_count_, target_count_;
  double noise_variance_;
  RowMatrix kernel_;              // (markers x markers + targets): exp(-d^2 / (2 length^2))
  std::vector<Mat3> along_skin_;  // (pads) projector onto the plane of a pad's facets
  std::vector<int> slip_of_;      // (pads) first column of its slip; -1: does not hold
  int slips_ = 0;
  RowMatrix slip_rows_;

  std::vector<Vec3> at_marker_;      // (markers)
  std::vector<double> uncertainty_;  // (markers)
  Eigen::VectorXd slip_;             // (3 pads) mm
  std::vector<Vec3> at_target_;      // (targets)
  std::vector<Mat3> covariance_;     // (targets)

  // Workspace.
  bool has_slip_ = false;
  std::vector<int> known_;         // markers whose b says something about their neighbours'
  Eigen::MatrixXd kernel_factor_;  // (markers x markers)
  RowMatrix work_;                 // (markers x 3 + targets + 9 pads): b, targets' kernels, slip rows by axis
  Eigen::MatrixXd slip_factor_;    // (3 pads x 3 pads)
  RowMatrix slip_work_;            // (3 pads x 3)
};

}  // namespace tissued::core
