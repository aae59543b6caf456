#pragma once

#include <string>
#include <string_view>

#include "protocol/mesh_file.hpp"

namespace tissued::protocol {

/// Reads the text of a Gmsh file, version 2.2 or 4.1, ASCII; `name` is for messages. Lengths are taken as mm.
///
/// Points and lines are skipped; any other element that is not a linear triangle or tetrahedron is refused, and so is
/// a binary file. In 4.1 physical groups come from $Entities, several per entity where given; in 2.2 an element that
/// belongs to several groups is written once per group, and such repeats are joined.
/// Throws MeshError.
MeshFile parse_gmsh(std::string_view text, const std::string& name);

}  // namespace tissued::protocol
