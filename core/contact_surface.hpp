// The skin that probes may touch anywhere: the places of it that must stay outside of a probe, and how they answer a
// force. Immutable; part of the model.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/scene.hpp"
#include "core/sparse_cholesky.hpp"

namespace tissued::core {

// A node of the skin, or the middle of an edge: position = sum_a weights[a] x[nodes[a]].
struct ContactSample {
  int count = 1;  // of nodes
  std::array<int, 2> nodes{};
  std::array<double, 2> weights{1.0, 0.0};
  std::array<int, 2> rows{-1, -1};     // of the factor's order; -1: a node that never moves
  std::array<int, 2> columns{-1, -1};  // of the compliance; likewise
  Vec3 outwards = Vec3::UnitZ();       // unit, at rest, mean of the facets around it
};

class ContactSurface {
 public:
  // Without probes: no samples. Nodes that never move (free_index -1) are none.
  ContactSurface(const Scene& scene, const SparseCholesky& factor, const std::vector<int>& free_index);

  int count() const { return static_cast<int>(samples_.size()); }
  std::span<const ContactSample> samples() const { return samples_; }
  // mm/mN: K^-1 between two samples, nothing held but the fixed nodes; the same for every axis.
  double compliance(const ContactSample& one, const ContactSample& other) const {
    double sum = 0.0;
    for (int a = 0; a < one.count; ++a)
      for (int b = 0; b < other.count; ++b)
        if (one.columns[a] >= 0 && other.columns[b] >= 0)
          sum += one.weights[a] * other.weights[b] * compliance_(one.columns[a], other.columns[b]);
    return sum;
  }

  // An edge longer than this is sampled in its middle, too: a probe's edge would sink in between its ends.
  static constexpr double kSpacing = 4.0;  // mm

 private:
  std::vector<ContactSample> samples_;
  Eigen::MatrixXf compliance_;  // (free skin nodes x free skin nodes) mm/mN
};

inline Vec3 position_of(const ContactSample& sample, const NodeField& x) {
  Eigen::Vector4d p = Eigen::Vector4d::Zero();
  for (int a = 0; a < sample.count; ++a) p += sample.weights[a] * x.row(sample.nodes[a]).transpose();
  return p.head<3>();
}

}  // namespace tissued::core
