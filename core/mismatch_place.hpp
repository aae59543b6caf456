// Where in the body something is missing: the node at which one force explains most of what markers show and the
// assumed physics does not. Of a node's force f the markers would see K f, K its rows of the compliance; the best f
// explains |K^T m|^2 / |K|^2 of the misfit's |m|^2, axis by axis. Summed over the loads at which there was evidence.
#pragma once

#include <span>
#include <vector>

#include "core/rest_compliance.hpp"

namespace tissued::core {

class MismatchPlace {
 public:
  explicit MismatchPlace(const Model& model);

  void reset();
  // Evidence of so much weight: the misfit, (markers) mm, of the markers in `used`. Ignored while an earlier one is
  // still being looked into.
  void add(std::span<const Vec3> misfit, std::span<const int> used, double weight);
  // One frame's share of the nodes.
  void advance(const RestCompliance& compliance);

  bool known() const { return best_ >= 0; }
  const Vec3& place() const { return nodes_[static_cast<std::size_t>(best_)]; }  // mm, tissue

 private:
  double explained(const RowMatrix& columns, std::size_t node) const;

  std::vector<Vec3> nodes_;     // (free) mm, at rest
  std::vector<double> scores_;  // (free)
  std::vector<Vec3> misfit_;    // (markers) mm; zero where not used
  std::vector<int> used_;
  double weight_ = 0.0, square_ = 0.0, stiffest_ = 0.0;
  std::size_t next_, per_frame_;
  int best_ = -1;
};

}  // namespace tissued::core
