// The filter beyond the paper's: what markers say that the simulation does not is first of all a statement about the
// body. An extended Kalman filter learns its log-stiffness, a smooth random field, and the simulation runs on with what
// was learnt; what no such field explains is a discrepancy b: pads that slip, and what fades away from the markers.
//
// A measured displacement is
//   d = simulated(c) + J (c - c_estimate) + b(marker) + noise
// with c the coefficients of the field, J from the compliance at rest and the stresses now. b grows in proportion to
// the load, the largest simulated displacement of a marker or of the skin under a probe. Where pads push by their
// poses, markers say nothing about the stiffness as a whole; a measured pad force, f = simulated(c) + J (c -
// c_estimate) + noise, does.
#pragma once

#include <span>
#include <vector>

#include "core/admm.hpp"
#include "core/discrepancy.hpp"
#include "core/marker_filter.hpp"
#include "core/rest_compliance.hpp"

namespace tissued::core {

class StiffnessFilter {
 public:
  // Throws ModelError where the body is not held.
  StiffnessFilter(const Model& model, const FilterOptions& options);

  // The same body, factored for another time step: what was learnt stays.
  void use(const Model& model) { model_ = &model; }
  // Writes what was learnt into a state that was begun anew.
  void apply(AdmmState& state);
  // Forgets all that was learnt.
  void reset();
  // One frame: gates the markers, learns from them and from measured pad forces where the load moved on, and estimates
  // the discrepancy. Writes the moduli of the state's domains, never positions: skin on a probe stays on it.
  // pad_forces: (pads) N, simulated. pressed: mm, how far probes have pushed the skin, 0 where none touches; it is a
  // load like that of pads, but nothing is learnt from it, for the compliance does not know of the places that a probe
  // holds. dt: s since the last call.
  Innovation correct(std::span<const Vec3> markers, std::span<const std::uint8_t> seen, std::span<const PadInput> pads,
                     std::span<const Vec3> pad_forces, double pressed, double dt, AdmmState& state);

  // mm, the discrepancy at a target: to be added to the simulated position.
  const Vec3& target_shift(int target) const { return discrepancy_.at_target(target); }
  // mm^2, of a target's position.
  const Mat3& target_covariance(int target) const { return target_covariance_[static_cast<std::size_t>(target)]; }
  // Natural logarithm of what the stiffness at a node is multiplied with.
  double log_stiffness(int node) const { return log_stiffness_[node]; }
  int coefficients() const { return static_cast<int>(field_.cols()); }
  // Rows for markers, then targets: mm per unit of a coefficient; then pads: N. At the last load learnt from. The last
  // coefficient is the stiffness as a whole.
  const RowMatrix& sensitivity() const { return sensitivity_; }

  const Discrepancy& discrepancy() const { return discrepancy_; }

  // Of the newest frame.
  std::span<const Vec3> innovation() const { return innovation_; }  // (markers) mm; of those used
  std::span<const int> used() const { return used_; }               // markers, swapped labels put right
  std::span<const Vec3> moved() const { return displacement_; }     // (markers) mm, simulated, since rest
  const RestCompliance& compliance() const { return compliance_; }  // under the pads that hold
  bool has_learnt() const { return learnt_; }

 private:
  void measure(std::span<const Vec3> markers, std::span<const std::uint8_t> seen, double pressed,
               const AdmmState& state);
  void gate(std::span<const Vec3> markers);
  bool unswap(std::size_t first, std::span<const Vec3> markers);
  double shown_variance();
  bool plausible(int marker, const Vec3& innovation) const;
  void see_pads(std::span<const PadInput> pads, std::span<const Vec3> pad_forces);
  bool load_is_news(double pressed, double dt);
  void learn_in_parts(AdmmState& state);
  void add_sensitivity(const StrainDomain& domain, const AdmmState& state);
  void finish_sensitivity();
  void learn();
  int fill_rows();
  void fill_spread(int rows);
  void update_covariances();
  double expected_variance() const { return share_ * share_ * load_ * load_; }
  double slip_variance() const { return slip_share_ * slip_share_ * load_ * load_; }

  const Model* model_;
  RestCompliance compliance_;
  int marker_count_, target_count_;
  RowMatrix field_;  // (nodes x r); the last column is constant
  double noise_variance_, initial_share_, slip_share_;
  Discrepancy discrepancy_;

  // What was learnt.
  Eigen::VectorXd coefficients_, log_stiffness_;  // (r), (nodes)
  RowMatrix covariance_;                          // (r x r)
  double share_;                                  // of the load: standard deviation of the discrepancy
  bool learnt_ = false;

  // Of the load now.
  std::vector<Vec3> displacement_;  // (markers) mm, simulated
  std::vector<Vec3> learnt_at_;     // (markers) the same when last learnt from
  std::vector<Vec3> resting_at_;    // (markers) the same when the load last moved
  double resting_ = 0.0;            // s without a move
  double load_ = 0.0, travel_ = 0.0, peak_load_ = 0.0, sensitivity_load_ = 0.0;  // mm
  std::vector<std::uint8_t> held_;                                               // (pads) that the compliance knows of
  RowMatrix sensitivity_;                                                        // (3 (markers + targets + pads) x r)
  std::size_t next_domain_ = 0;  // of the sensitivities that are being computed

  // Of this frame.
  std::vector<Vec3> innovation_;  // (markers)
  std::vector<int> used_, refused_;
  int swapped_ = 0;
  std::vector<int> weighed_;            // pads whose force is measured
  std::vector<Vec3> force_innovation_;  // (pads) N
  std::vector<double> force_noise_;     // (pads) N, standard deviation per axis
  bool forced_ = false;                 // a pad pushes by its force: how far, the stiffness as a whole decides
  double variance_ = 0.0;        // mm^2 per axis, of the discrepancy but for slip: expected, or what innovations show
  std::vector<double> squares_;  // (markers used)
  std::vector<Vec3> displacement_before_;  // (markers) mm, simulated, a frame ago
  std::vector<double> moved_;              // (markers) mm, since then
  std::vector<Mat3> learnt_covariance_;    // (markers + targets) mm^2, by what is not known of the stiffness
  std::vector<Mat3> target_covariance_;    // (targets)

  // Workspace.
  RowMatrix domain_row_, at_nodes_;  // (1, nodes x 3 (markers + targets))
  std::vector<double> corner_factors_;
  std::vector<int> corner_rows_;
  RowMatrix rows_, spread_rows_, gain_;  // (3 (markers + pads) x r)
  Eigen::MatrixXd spread_;               // (3 (markers + pads) x 3 (markers + pads))
  Eigen::VectorXd news_;                 // (3 (markers + pads)) mm, N
};

}  // namespace tissued::core
