#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "protocol/mesh_builder.hpp"
#include "protocol/record_reader.hpp"

// The sections whose layout differs between the two versions of Gmsh's format. Each reader is called with the section's
// first line, such as `$Nodes`, as the current one, leaves its last, `$EndNodes`, as the current one, and refuses what
// is cut off, too short or too long.
namespace tissued::protocol {

/// The shortest line that a Gmsh list can hold takes two bytes: a digit and its line end.
inline constexpr std::size_t kGmshBytesPerLine = 2;

/// How many nodes an element of this Gmsh type has, as far as it is read: 1 point (skipped), 2 line (skipped), 3
/// triangle, 4 tetrahedron. Refuses all other types by name.
int gmsh_element_nodes(const RecordReader& reader, int type);

/// Goes to the line of entry `i` (from 0) of the `count` that a section says; refuses the section's end there.
void require_gmsh_line(RecordReader& reader, const char* what, std::size_t i, std::size_t count);

/// Goes to the next line, which must be `end`, such as `$EndNodes`.
void require_gmsh_end(RecordReader& reader, const std::string& end);

/// Version 2.2: one node a line, one element a line; an element carries the tag of its physical group.
void read_gmsh2_nodes(RecordReader& reader, MeshBuilder& builder);
void read_gmsh2_elements(RecordReader& reader, MeshBuilder& builder);

/// Version 4.1: the physical groups of every surface and volume, by its tag; none where a file has no $Entities.
struct GmshEntities {
  std::map<int, std::vector<int>> surfaces;
  std::map<int, std::vector<int>> volumes;
  bool given = false;
};

/// Version 4.1: nodes and elements stand in blocks, one per entity.
GmshEntities read_gmsh4_entities(RecordReader& reader);
void read_gmsh4_nodes(RecordReader& reader, MeshBuilder& builder);
void read_gmsh4_elements(RecordReader& reader, const GmshEntities& entities, MeshBuilder& builder);

}  // namespace tissued::protocol
