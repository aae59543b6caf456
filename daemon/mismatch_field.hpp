// The mismatch map of a diagnosis, a number per tetrahedron, as a smooth field that can be drawn.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh.hpp"

namespace tissued::daemon {

/// (nodes) means over the tetrahedra around a node, weighted by volume, as shares of the largest: 0 to 1. Empty where
/// the map has not one number per tetrahedron or nothing above zero; what is not finite counts as zero.
std::vector<double> mismatch_at_nodes(const core::TetMesh& mesh, const std::vector<double>& map);

/// The node at which the field is largest, mm. nodes: not empty.
core::Vec3 mismatch_peak(const core::TetMesh& mesh, const std::vector<double>& nodes);

/// Samples of the field at the corners of cubes around the body.
struct MismatchGrid {
  std::array<int, 3> size{};  ///< samples along x, y and z
  core::Vec3 origin;          ///< mm, tissue: the first sample
  double spacing = 1.0;       ///< mm
  /// (x fastest, then y, z) 0 to 255. Samples outside of the body take after their neighbours inside, so that
  /// interpolation holds up to the skin; those further out are zero.
  std::vector<std::uint8_t> values;
};

/// nodes: of mismatch_at_nodes. cells: along the body's longest side.
MismatchGrid mismatch_grid(const core::TetMesh& mesh, const std::vector<double>& nodes, int cells);

}  // namespace tissued::daemon
