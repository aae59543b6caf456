#include "core/particle_clusters.hpp"

#include <algorithm>
#include <limits>

#include "core/polar_rotation.hpp"

namespace tissued::core {

namespace {

Vec3 mean_of(const ParticleLattice& lattice, const std::vector<int>& particles) {
  Vec3 sum = Vec3::Zero();
  for (int particle : particles) sum += lattice.rest(particle);
  return sum / static_cast<double>(particles.size());
}

std::vector<Vec3> cluster_centers(const ParticleLattice& lattice, double spacing) {
  std::vector<std::uint8_t> reached(static_cast<std::size_t>(lattice.count()), 0);
  std::vector<Vec3> centers;
  for (int particle = 0; particle < lattice.count(); ++particle) {
    if (reached[static_cast<std::size_t>(particle)]) continue;
    const std::vector<int> around = lattice.within(lattice.rest(particle), spacing);
    for (int neighbour : around) reached[static_cast<std::size_t>(neighbour)] = 1;
    centers.push_back(mean_of(lattice, around));
  }
  return centers;
}

std::size_t nearest_center(const std::vector<Vec3>& centers, const Vec3& position) {
  const auto nearest = std::min_element(centers.begin(), centers.end(), [&](const Vec3& a, const Vec3& b) {
    return (a - position).squaredNorm() < (b - position).squaredNorm();
  });
  return static_cast<std::size_t>(nearest - centers.begin());
}

}  // namespace

ParticleClusters::ParticleClusters(const ParticleLattice& lattice, double spacing, double radius) {
  const std::vector<Vec3> centers = cluster_centers(lattice, spacing);
  std::vector<std::vector<int>> members;
  std::vector<int> clusters_of(static_cast<std::size_t>(lattice.count()), 0);
  for (const Vec3& center : centers) {
    members.push_back(lattice.within(center, radius));
    for (int member : members.back()) ++clusters_of[static_cast<std::size_t>(member)];
  }
  for (int i = 0; i < lattice.count(); ++i) {
    if (clusters_of[static_cast<std::size_t>(i)] > 0) continue;
    members[nearest_center(centers, lattice.rest(i))].push_back(i);
    clusters_of[static_cast<std::size_t>(i)] = 1;
  }
  // A cluster whose sphere holds no particle, and that none has joined, is none.
  std::erase_if(members, [](const std::vector<int>& cluster) { return cluster.empty(); });
  for (int count : clusters_of) share.push_back(1.0 / count);
  first.push_back(0);
  for (const std::vector<int>& cluster : members) {
    Vec3 mean = Vec3::Zero();
    double total = 0.0;
    for (int member : cluster) {
      mean += share[static_cast<std::size_t>(member)] * lattice.rest(member);
      total += share[static_cast<std::size_t>(member)];
    }
    mean /= total;
    for (int member : cluster) {
      particle.push_back(member);
      arm.emplace_back();
      arm.back() << lattice.rest(member) - mean, share[static_cast<std::size_t>(member)] / total;
    }
    first.push_back(static_cast<int>(particle.size()));
  }
}

ClusterState::ClusterState(const ParticleClusters& clusters)
    : rotation(static_cast<std::size_t>(clusters.count()), Eigen::Quaterniond::Identity()),
      goal(static_cast<Eigen::Index>(clusters.share.size()), 4) {}

void ClusterState::reset() { std::fill(rotation.begin(), rotation.end(), Eigen::Quaterniond::Identity()); }

void match_shapes(const ParticleClusters& clusters, double alpha, std::span<const double> mobility, NodeField& x,
                  ClusterState& state) {
  using Eigen::Vector4d;
  state.goal.setZero();
  for (int c = 0; c < clusters.count(); ++c) {
    const int begin = clusters.first[c], end = clusters.first[c + 1];
    // Weighted arms add up to zero, so that positions need not be taken from their mean first.
    Vector4d mean = Vector4d::Zero(), moment[3] = {Vector4d::Zero(), Vector4d::Zero(), Vector4d::Zero()};
    for (int k = begin; k < end; ++k) {
      const Vector4d& arm = clusters.arm[k];
      const Vector4d weighted = arm[3] * x.row(clusters.particle[k]).transpose();
      mean += weighted;
      for (int axis = 0; axis < 3; ++axis) moment[axis] += arm[axis] * weighted;
    }
    Mat3 a;
    for (int axis = 0; axis < 3; ++axis) a.col(axis) = moment[axis].head<3>();
    polar_rotation(a, state.rotation[c]);
    const Mat3 turn = state.rotation[c].toRotationMatrix();
    Vector4d columns[3];
    for (int axis = 0; axis < 3; ++axis) columns[axis] << turn.col(axis), 0.0;
    for (int k = begin; k < end; ++k) {
      const Vector4d& arm = clusters.arm[k];
      state.goal.row(clusters.particle[k]) +=
          (mean + arm[0] * columns[0] + arm[1] * columns[1] + arm[2] * columns[2]).transpose();
    }
  }
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const Vector4d goal = clusters.share[i] * state.goal.row(i).transpose();
    x.row(i) += alpha * mobility[i] * (goal.transpose() - x.row(i));
  }
}

}  // namespace tissued::core
