#include "core/particle_readout.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace tissued::core {

namespace {

constexpr double kSupport = 2.0;  // spacings
constexpr double kWiden = 1.25;
constexpr double kWidest = 8.0;     // spacings
constexpr std::size_t kFewest = 8;  // particles
// Of the smallest pivot to the largest: below, particles lie nearly in a plane.
constexpr double kFlat = 1e-4;

using Basis = Eigen::Vector4d;  // 1 and the place relative to the foot, in units of the support

Basis basis_at(const Vec3& position, const Vec3& foot, double support) {
  const Vec3 local = (position - foot) / support;
  return {1.0, local.x(), local.y(), local.z()};
}

double kernel(double squared_distance, double support) {
  const double inside = std::max(0.0, 1.0 - squared_distance / (support * support));
  return inside * inside;
}

}  // namespace

ParticleReadout::Point ParticleReadout::point_at(const TetMesh& mesh, const MaterialPoint& point) {
  MaterialPoint foot = point;
  for (std::size_t a = 0; a < 4; ++a) foot.weights[a] -= point.stalk[a];
  return {rest_position(mesh, point), rest_position(mesh, foot)};
}

ParticleReadout::ParticleReadout(const ParticleLattice& lattice, PbdReadout kind, std::span<const Point> points) {
  for (const Point& point : points) {
    if (kind == PbdReadout::nearest) {
      add_nearest(lattice, point);
    } else {
      add_blend(lattice, point);
    }
    first_.push_back(static_cast<int>(particle_.size()));
  }
}

void ParticleReadout::add_nearest(const ParticleLattice& lattice, const Point& point) {
  particle_.push_back(lattice.nearest(point.foot));
  weight_.push_back(1.0);
}

void ParticleReadout::add_blend(const ParticleLattice& lattice, const Point& point) {
  for (double support = kSupport * lattice.spacing(); support <= kWidest * lattice.spacing(); support *= kWiden) {
    const std::vector<int> around = lattice.within(point.foot, support);
    if (around.size() < kFewest) continue;
    Eigen::Matrix4d moment = Eigen::Matrix4d::Zero();
    for (int i : around) {
      const Basis basis = basis_at(lattice.rest(i), point.foot, support);
      moment += kernel((lattice.rest(i) - point.foot).squaredNorm(), support) * basis * basis.transpose();
    }
    Eigen::FullPivLU<Eigen::Matrix4d> factor(moment);
    factor.setThreshold(kFlat);
    if (!factor.isInvertible()) continue;
    const Basis dual = factor.solve(basis_at(point.position, point.foot, support));
    for (int i : around) {
      particle_.push_back(i);
      weight_.push_back(kernel((lattice.rest(i) - point.foot).squaredNorm(), support) *
                        dual.dot(basis_at(lattice.rest(i), point.foot, support)));
    }
    return;
  }
  add_nearest(lattice, point);  // a body of a single layer says nothing about turns
}

Vec3 ParticleReadout::displacement(int point, const NodeField& rest, const NodeField& x) const {
  Eigen::RowVector4d sum = Eigen::RowVector4d::Zero();
  for (int k = first_[point]; k < first_[point + 1]; ++k)
    sum += weight_[k] * (x.row(particle_[k]) - rest.row(particle_[k]));
  return sum.head<3>().transpose();
}

}  // namespace tissued::core
