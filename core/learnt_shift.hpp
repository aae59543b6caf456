// What the learnt stiffness does to the markers: how far the simulation that runs on with it is from the one that was
// assumed. With what markers still miss it is all that the filter makes up for.
//
// The learnt simulation is in equilibrium with moduli e^c k; of the assumed ones, k, a force is left over,
//   f = sum over domains of (e^c - 1) V P(F) grad N,
// and a Newton step from here takes the assumed body to where it would be: x - x_assumed = -K f, K the compliance of
// the body at rest under the pads that hold.
#pragma once

#include <vector>

#include "core/admm.hpp"
#include "core/rest_compliance.hpp"

namespace tissued::core {

class LearntShift {
 public:
  explicit LearntShift(const Model& model);

  void reset();
  // One frame's share of the work: after some ten frames every domain and node has had its turn.
  void advance(const Model& model, const RestCompliance& compliance, const AdmmState& state);

  const Vec3& at_marker(int marker) const { return at_marker_[static_cast<std::size_t>(marker)]; }  // mm

 private:
  void add_forces(const Model& model, const AdmmState& state, std::size_t end);
  void add_answers(const RestCompliance& compliance, std::size_t end);

  std::vector<std::size_t> slot_of_;  // (domains) its lane in the blocks of the model
  std::size_t domains_per_frame_, rows_per_frame_;
  std::size_t next_domain_ = 0, next_row_ = 0;
  std::vector<double> force_;   // (3 free) mN
  std::vector<double> answer_;  // (3 markers, then what else the compliance observes) mm
  std::vector<Vec3> at_marker_;
};

}  // namespace tissued::core
