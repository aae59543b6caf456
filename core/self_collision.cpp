#include "core/self_collision.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tissued::core {

namespace {

constexpr double kNeighbours = 2.0;     // spacings, at rest
constexpr double kReach = 1.5;          // spacings, at which a pair is watched during a substep
constexpr std::size_t kPairsEach = 16;  // per particle, for which there is room

}  // namespace

SelfCollision::SelfCollision(const ParticleLattice& lattice, double friction)
    : spacing_(lattice.spacing()), friction_(friction) {
  for (int i = 0; i < lattice.count(); ++i) {
    if (!lattice.on_surface(i)) continue;
    surface_.push_back(i);
    rest_.push_back(lattice.rest(i));
  }
  cells_.resize(surface_.size());
  next_.resize(surface_.size());
  head_.resize(std::bit_ceil(2 * surface_.size() + 1));
  pairs_.reserve(kPairsEach * surface_.size());
}

SelfCollision::Cell SelfCollision::cell_of(const Vec3& position) const {
  constexpr double kFar = 1e6;  // cells; fmin and fmax take what is not a number there, too
  Cell cell;
  for (int axis = 0; axis < 3; ++axis) {
    const double place = std::floor(position[axis] / (kReach * spacing_));
    cell[static_cast<std::size_t>(axis)] = static_cast<int>(std::fmax(-kFar, std::fmin(kFar, place)));
  }
  return cell;
}

std::size_t SelfCollision::bucket_of(const Cell& cell) const {
  const auto hash = static_cast<std::size_t>(cell[0]) * 73856093u ^ static_cast<std::size_t>(cell[1]) * 19349663u ^
                    static_cast<std::size_t>(cell[2]) * 83492791u;
  return hash & (head_.size() - 1);
}

void SelfCollision::find(const NodeField& x) {
  std::fill(head_.begin(), head_.end(), -1);
  pairs_.clear();
  for (std::size_t k = 0; k < surface_.size(); ++k) {
    const int one = static_cast<int>(k);
    cells_[k] = cell_of(x.row(surface_[k]).head<3>().transpose());
    // Only those that came before are in the grid: every pair is found once.
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
          pair_with_cell(x, one, {cells_[k][0] + dx, cells_[k][1] + dy, cells_[k][2] + dz});
    int& head = head_[bucket_of(cells_[k])];
    next_[k] = head;
    head = one;
  }
}

void SelfCollision::pair_with_cell(const NodeField& x, int one, const Cell& cell) {
  const double near = kReach * spacing_, apart = kNeighbours * spacing_ * (1.0 + 1e-9);
  for (int other = head_[bucket_of(cell)]; other >= 0; other = next_[other]) {
    if (cells_[other] != cell || (rest_[one] - rest_[other]).squaredNorm() <= apart * apart) continue;
    const double squared = (x.row(surface_[one]) - x.row(surface_[other])).squaredNorm();
    if (squared < near * near && pairs_.size() < pairs_.capacity()) pairs_.push_back({surface_[one], surface_[other]});
  }
}

void SelfCollision::resolve(std::span<const double> mobility, const NodeField& start, NodeField& x) const {
  for (const Pair& pair : pairs_) {
    const double weight = mobility[pair.one] + mobility[pair.other];
    const Eigen::RowVector4d between = x.row(pair.one) - x.row(pair.other);
    const double distance = between.norm();
    if (weight == 0.0 || !(distance < spacing_) || distance == 0.0) continue;
    const Eigen::RowVector4d normal = between / distance;
    const double push = spacing_ - distance;
    const Eigen::RowVector4d moved = between - (start.row(pair.one) - start.row(pair.other));
    const Eigen::RowVector4d slide = moved - moved.dot(normal) * normal;
    const double length = slide.norm(), limit = friction_ * push;
    const Eigen::RowVector4d apart = push * normal - slide * (length > limit ? limit / length : 1.0);
    x.row(pair.one) += mobility[pair.one] / weight * apart;
    x.row(pair.other) -= mobility[pair.other] / weight * apart;
  }
}

}  // namespace tissued::core
