#include "core/particle_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tissued::core {

namespace {

constexpr double kMostCells = 1e7;
constexpr double kRounding = 1e-9;  // of a cell, or of a barycentric coordinate

// Cells from lo to hi of a box.
template <typename Visit>
void for_each_cell(const std::array<int, 3>& lo, const std::array<int, 3>& hi, const Visit& visit) {
  for (int k = lo[2]; k <= hi[2]; ++k)
    for (int j = lo[1]; j <= hi[1]; ++j)
      for (int i = lo[0]; i <= hi[0]; ++i) visit(std::array<int, 3>{i, j, k});
}

}  // namespace

ParticleLattice::ParticleLattice(const TetMesh& mesh, double spacing) : spacing_(spacing) {
  const Vec3 low = mesh.rest.colwise().minCoeff().transpose(), high = mesh.rest.colwise().maxCoeff().transpose();
  const Vec3 cells = ((high - low).array() / spacing - kRounding).ceil().max(1.0);
  if (!(cells.prod() <= kMostCells))
    throw ModelError("simulator.pbd.particle_spacing " + std::to_string(spacing) + " mm makes too many particles");
  for (int axis = 0; axis < 3; ++axis) cells_[axis] = static_cast<int>(cells[axis]);
  first_ = 0.5 * (low + high) - 0.5 * spacing * (cells - Vec3::Ones());
  particle_of_.assign(static_cast<std::size_t>(cells.prod()), -1);
  fill(mesh);
  if (rest_.empty())
    throw ModelError("simulator.pbd.particle_spacing " + std::to_string(spacing) +
                     " mm leaves no particle in the mesh");
}

void ParticleLattice::fill(const TetMesh& mesh) {
  constexpr int kFilled = 0;
  for (const Tet& tet : mesh.tets) {
    Vec3 low = mesh.node(tet[0]), high = low;
    for (int node : tet) {
      low = low.cwiseMin(mesh.node(node));
      high = high.cwiseMax(mesh.node(node));
    }
    for_each_cell(cell_at(low), cell_at(high), [&](const Cell& cell) {
      const std::array<double, 4> weights = barycentric_in(mesh, tet, middle(cell));
      if (*std::min_element(weights.begin(), weights.end()) >= -kRounding) particle_of_[index(cell)] = kFilled;
    });
  }
  for_each_cell({0, 0, 0}, {cells_[0] - 1, cells_[1] - 1, cells_[2] - 1}, [&](const Cell& cell) {
    if (particle_of_[index(cell)] != kFilled) return;
    particle_of_[index(cell)] = count();
    rest_.push_back(middle(cell));
    cell_.push_back(cell);
  });
}

ParticleLattice::Cell ParticleLattice::cell_at(const Vec3& position) const {
  Cell cell;
  for (int axis = 0; axis < 3; ++axis) {
    const double place = std::round((position[axis] - first_[axis]) / spacing_);
    cell[axis] = static_cast<int>(std::clamp(place, 0.0, cells_[axis] - 1.0));
  }
  return cell;
}

bool ParticleLattice::on_surface(int particle) const {
  const Cell& cell = cell_[static_cast<std::size_t>(particle)];
  for (int axis = 0; axis < 3; ++axis)
    for (int step : {-1, 1}) {
      Cell next = cell;
      next[axis] += step;
      if (next[axis] < 0 || next[axis] >= cells_[axis] || particle_of_[index(next)] < 0) return true;
    }
  return false;
}

std::vector<int> ParticleLattice::within(const Vec3& center, double radius) const {
  std::vector<int> found;
  const double limit = radius * radius * (1.0 + kRounding);
  for_each_cell(cell_at(center.array() - radius), cell_at(center.array() + radius), [&](const Cell& cell) {
    const int particle = particle_of_[index(cell)];
    if (particle >= 0 && (rest(particle) - center).squaredNorm() <= limit) found.push_back(particle);
  });
  return found;
}

int ParticleLattice::nearest(const Vec3& position) const {
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int particle = 0; particle < count(); ++particle) {
    const double squared = (rest(particle) - position).squaredNorm();
    if (squared < least) {
      least = squared;
      best = particle;
    }
  }
  return best;
}

}  // namespace tissued::core
