#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "protocol/mesh_file.hpp"

namespace tissued::protocol {

/// One file of a TetGen set, in memory; `name` is for messages.
struct TetgenText {
  std::string name;
  std::string_view text;
};

/// Reads a TetGen set: .node, .ele and, where there is one, .face. Lengths are taken as mm.
///
/// Numbering starts at 0 or 1, as the first point says. Attributes of points are skipped, `#` starts a comment.
/// Tetrahedra of ten nodes are refused.
/// Throws MeshError.
MeshFile parse_tetgen(const TetgenText& node, const TetgenText& ele, const std::optional<TetgenText>& face);

}  // namespace tissued::protocol
