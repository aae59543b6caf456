#include "daemon/mismatch_field.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tissued::daemon {
namespace {

constexpr double kOutside = -1.0;
constexpr int kRim = 2;  // samples beyond the skin that take after the inside

// Samples with their values, kOutside where none was set.
struct Samples {
  MismatchGrid& grid;
  std::vector<double> values;

  std::size_t at(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * grid.size[1] + j) * static_cast<std::size_t>(grid.size[0]) + i;
  }
};

// Sets every sample within the tetrahedron.
void fill(Samples& samples, const core::TetMesh& mesh, const core::Tet& tet, const std::vector<double>& nodes) {
  const MismatchGrid& grid = samples.grid;
  core::Mat3 edges;
  core::Vec3 low = mesh.node(tet[0]), high = low;
  for (int a = 1; a < 4; ++a) {
    const core::Vec3 corner = mesh.node(tet[a]);
    edges.col(a - 1) = corner - mesh.node(tet[0]);
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  const core::Mat3 inverse = edges.inverse();
  const Eigen::Vector3i first = ((low - grid.origin) / grid.spacing).array().ceil().cast<int>();
  const Eigen::Vector3i last = ((high - grid.origin) / grid.spacing).array().floor().cast<int>();
  for (int k = first.z(); k <= last.z(); ++k) {
    for (int j = first.y(); j <= last.y(); ++j) {
      for (int i = first.x(); i <= last.x(); ++i) {
        const core::Vec3 position = grid.origin + grid.spacing * core::Vec3(i, j, k);
        const core::Vec3 local = inverse * (position - mesh.node(tet[0]));
        const double weight = 1.0 - local.sum();
        if (weight < -1e-9 || local.minCoeff() < -1e-9) continue;
        samples.values[samples.at(i, j, k)] =
            weight * nodes[tet[0]] + local[0] * nodes[tet[1]] + local[1] * nodes[tet[2]] + local[2] * nodes[tet[3]];
      }
    }
  }
}

// Samples without a value become the mean of their neighbours with one.
void widen(Samples& samples) {
  const auto& size = samples.grid.size;
  const std::vector<double> before = samples.values;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        if (before[samples.at(i, j, k)] != kOutside) continue;
        double sum = 0.0;
        int count = 0;
        for (int c = std::max(k - 1, 0); c <= std::min(k + 1, size[2] - 1); ++c) {
          for (int b = std::max(j - 1, 0); b <= std::min(j + 1, size[1] - 1); ++b) {
            for (int a = std::max(i - 1, 0); a <= std::min(i + 1, size[0] - 1); ++a) {
              const double value = before[samples.at(a, b, c)];
              if (value == kOutside) continue;
              sum += value;
              ++count;
            }
          }
        }
        if (count > 0) samples.values[samples.at(i, j, k)] = sum / count;
      }
    }
  }
}

}  // namespace

std::vector<double> mismatch_at_nodes(const core::TetMesh& mesh, const std::vector<double>& map) {
  if (std::ssize(map) != mesh.tet_count()) return {};
  std::vector<double> sums(static_cast<std::size_t>(mesh.node_count()), 0.0), volumes = sums;
  for (std::size_t t = 0; t < map.size(); ++t) {
    if (!std::isfinite(map[t])) continue;
    const double volume = core::signed_volume(mesh, mesh.tets[t]);
    for (const int node : mesh.tets[t]) {
      sums[node] += volume * std::max(map[t], 0.0);
      volumes[node] += volume;
    }
  }
  double most = 0.0;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (volumes[i] > 0.0) sums[i] /= volumes[i];
    most = std::max(most, sums[i]);
  }
  if (most <= 0.0) return {};
  for (double& value : sums) value /= most;
  return sums;
}

core::Vec3 mismatch_peak(const core::TetMesh& mesh, const std::vector<double>& nodes) {
  return mesh.node(static_cast<int>(std::ranges::max_element(nodes) - nodes.begin()));
}

MismatchGrid mismatch_grid(const core::TetMesh& mesh, const std::vector<double>& nodes, int cells) {
  MismatchGrid grid;
  const core::Vec3 low = mesh.rest.colwise().minCoeff(), high = mesh.rest.colwise().maxCoeff();
  grid.spacing = (high - low).maxCoeff() / cells;
  grid.origin = low - core::Vec3::Constant(kRim * grid.spacing);
  for (int axis = 0; axis < 3; ++axis) {
    grid.size[axis] = static_cast<int>(std::ceil((high - low)[axis] / grid.spacing)) + 2 * kRim + 1;
  }
  const std::size_t count = static_cast<std::size_t>(grid.size[0]) * grid.size[1] * grid.size[2];
  Samples samples{grid, std::vector<double>(count, kOutside)};
  for (const core::Tet& tet : mesh.tets) fill(samples, mesh, tet, nodes);
  for (int pass = 0; pass < kRim; ++pass) widen(samples);
  grid.values.reserve(count);
  for (const double value : samples.values) {
    grid.values.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0))));
  }
  return grid;
}

}  // namespace tissued::daemon
