#include "protocol/mesh_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace tissued::protocol {

namespace {

using Vector = std::array<double, 3>;

Vector difference(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double longest_edge(std::span<const Vector> nodes, const Tetrahedron& tet) {
  double longest_squared = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      const Vector edge = difference(nodes[tet[j]], nodes[tet[i]]);
      longest_squared = std::max(longest_squared, dot(edge, edge));
    }
  }
  return std::sqrt(longest_squared);
}

// Refuses flat tetrahedra; returns how many are wound the other way round.
std::size_t count_inverted(const MeshFile& mesh) {
  std::size_t inverted = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double volume = signed_volume(mesh.nodes, mesh.tets[t]);
    const double edge = longest_edge(mesh.nodes, mesh.tets[t]);
    // Written so that a volume of NaN, from coordinates whose cubes overflow, is refused as well.
    if (!(std::abs(volume) > kDegenerateVolumeRatio * edge * edge * edge)) {
      throw MeshError(mesh.tet_file, mesh.tet_lines[t],
                      "degenerate tetrahedron: volume " + std::to_string(volume) + " mm^3 with a longest edge of " +
                          std::to_string(edge) + " mm");
    }
    inverted += volume < 0.0;
  }
  return inverted;
}

[[noreturn]] void refuse_first(const MeshFile& mesh, bool negative, std::size_t count) {
  std::size_t t = 0;
  while ((signed_volume(mesh.nodes, mesh.tets[t]) < 0.0) != negative) ++t;
  const double volume = signed_volume(mesh.nodes, mesh.tets[t]);
  throw MeshError(mesh.tet_file, mesh.tet_lines[t],
                  std::string("inverted tetrahedron: signed volume ") + std::to_string(volume) +
                      " mm^3, the first of " + std::to_string(count) + " wound this way among " +
                      std::to_string(mesh.tets.size()));
}

void check_winding(MeshFile& mesh, Winding winding) {
  const std::size_t inverted = count_inverted(mesh);
  const std::size_t upright = mesh.tets.size() - inverted;
  if (inverted == 0) return;
  if (winding == Winding::positive || inverted <= upright) refuse_first(mesh, true, inverted);
  if (upright > 0) refuse_first(mesh, false, upright);
  for (Tetrahedron& tet : mesh.tets) std::swap(tet[2], tet[3]);
  mesh.orientation_reversed = true;
}

void check_nodes_used(const MeshFile& mesh) {
  std::vector<bool> used(mesh.nodes.size(), false);
  for (const Tetrahedron& tet : mesh.tets) {
    for (const std::int32_t node : tet) used[node] = true;
  }
  const auto unused = std::find(used.begin(), used.end(), false);
  if (unused == used.end()) return;
  const std::size_t count = std::count(unused, used.end(), false);
  throw MeshError(mesh.node_file, mesh.node_lines[unused - used.begin()],
                  "unreferenced node: no tetrahedron uses it, the first of " + std::to_string(count));
}

}  // namespace

double signed_volume(std::span<const Vector> nodes, const Tetrahedron& tet) {
  const Vector& a = nodes[tet[0]];
  return dot(cross(difference(nodes[tet[1]], a), difference(nodes[tet[2]], a)), difference(nodes[tet[3]], a)) / 6.0;
}

void check_geometry(MeshFile& mesh, Winding winding) {
  check_winding(mesh, winding);
  check_nodes_used(mesh);
}

}  // namespace tissued::protocol
