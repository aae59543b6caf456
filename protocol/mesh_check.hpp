#pragma once

#include <array>
#include <span>

#include "protocol/mesh_file.hpp"

namespace tissued::protocol {

/// A tetrahedron whose volume is not above this multiple of its longest edge cubed is degenerate; a regular one has
/// 0.118. Four points of a plane, written with the seven digits of a float, come out at some 1e-8.
inline constexpr double kDegenerateVolumeRatio = 1e-7;

/// (b - a) x (c - a) . (d - a) / 6, mm^3; positive where a, b, c turn counterclockwise as seen from d.
double signed_volume(std::span<const std::array<double, 3>> nodes, const Tetrahedron& tet);

/// How a format may wind its tetrahedra.
enum class Winding {
  positive,  ///< every signed volume must be positive
  uniform,   ///< all negative is accepted too: two nodes of every tetrahedron are then swapped
};

/// Refuses, with its line, a degenerate or inverted tetrahedron and a node that no tetrahedron uses. Sets
/// orientation_reversed where it had to swap. Throws MeshError.
void check_geometry(MeshFile& mesh, Winding winding);

}  // namespace tissued::protocol
