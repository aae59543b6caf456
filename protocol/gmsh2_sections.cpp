#include <cstdlib>

#include "protocol/gmsh_sections.hpp"

namespace tissued::protocol {

// `<nodes>`, then `<tag> <x> <y> <z>`.
void read_gmsh2_nodes(RecordReader& reader, MeshBuilder& builder) {
  reader.require_next("the number of nodes");
  const std::size_t nodes = reader.count("number of nodes", kGmshBytesPerLine);
  reader.end_record();
  builder.reserve_nodes(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    require_gmsh_line(reader, "node", i, nodes);
    const std::int64_t tag = reader.integer("node tag");
    const double x = reader.number("x");
    const double y = reader.number("y");
    const double z = reader.number("z");
    reader.end_record();
    builder.add_node(tag, {x, y, z}, reader.line());
  }
  require_gmsh_end(reader, "$EndNodes");
}

namespace {

// The tags of an element: `<number of tags> <physical group> <entity> ...`. Returns the physical group; 0 is none, and
// a negative one means an entity that is turned over.
int read_physical_group(RecordReader& reader) {
  const std::size_t tags = reader.count("number of tags", 1);
  int group = 0;
  for (std::size_t i = 0; i < tags; ++i) {
    const int tag = reader.small_integer("tag");
    if (i == 0) group = tag;
  }
  return std::abs(group);
}

// `<element> <type> <number of tags> <tags> <nodes>`
void read_element(RecordReader& reader, MeshBuilder& builder) {
  reader.integer("element number");
  const int nodes = gmsh_element_nodes(reader, reader.small_integer("element type"));
  const int group = read_physical_group(reader);
  std::array<std::int64_t, 4> tags{};
  for (int i = 0; i < nodes; ++i) tags[i] = reader.integer("node");
  reader.end_record();
  const std::span<const int> groups{&group, group == 0 ? 0U : 1U};
  if (nodes == 3) builder.add_triangle({tags[0], tags[1], tags[2]}, groups, reader.file(), reader.line());
  if (nodes == 4) builder.add_tet(tags, groups, reader.line(), Repeats::joined);
}

}  // namespace

void read_gmsh2_elements(RecordReader& reader, MeshBuilder& builder) {
  reader.require_next("the number of elements");
  const std::size_t elements = reader.count("number of elements", kGmshBytesPerLine);
  reader.end_record();
  builder.reserve_tets(elements);
  for (std::size_t i = 0; i < elements; ++i) {
    require_gmsh_line(reader, "element", i, elements);
    read_element(reader, builder);
  }
  require_gmsh_end(reader, "$EndElements");
}

}  // namespace tissued::protocol
