#include "protocol/tetgen_file.hpp"

#include <array>

#include "protocol/mesh_builder.hpp"
#include "protocol/record_reader.hpp"

namespace tissued::protocol {

namespace {

// The shortest line a list can hold takes two bytes: a digit and its line end.
constexpr std::size_t kBytesPerLine = 2;

// A 0-or-1 column of a first line.
bool read_flag(RecordReader& reader, const char* what) {
  const std::int64_t flag = reader.integer(what);
  if (flag != 0 && flag != 1) reader.fail(std::string(what) + " must be 0 or 1, not " + std::to_string(flag));
  return flag == 1;
}

void refuse_more(RecordReader& reader, std::size_t count, const char* what) {
  if (reader.next()) reader.fail("more than the " + std::to_string(count) + " " + what + " of the first line");
}

// Numbers run from the first one by one; TetGen knows no holes.
void read_number(RecordReader& reader, std::int64_t expected, const char* what) {
  const std::int64_t number = reader.integer(what);
  if (number != expected) {
    reader.fail(std::string(what) + " " + std::to_string(number) + " where " + std::to_string(expected) + " should be");
  }
}

// .node: `<points> <dimension> <attributes> <boundary markers>`, then `<point> <x> <y> <z> [attributes] [marker]`.
// Returns the number of the first point, 0 or 1.
std::int64_t read_nodes(const TetgenText& file, MeshBuilder& builder) {
  RecordReader reader(file.text, file.name, '#');
  reader.require_next("the number of points");
  const std::size_t points = reader.count("number of points", kBytesPerLine);
  if (reader.integer("dimension") != 3) reader.fail("the dimension must be 3");
  const std::size_t attributes = reader.count("number of attributes", 1);
  const bool marked = read_flag(reader, "boundary markers");
  reader.end_record();

  builder.reserve_nodes(points);
  std::int64_t first = 0;
  for (std::size_t i = 0; i < points; ++i) {
    reader.require_next("point", i, points);
    if (i == 0) {
      first = reader.integer("point number");
      if (first != 0 && first != 1) reader.fail("points are numbered from 0 or 1, not " + std::to_string(first));
    } else {
      read_number(reader, first + static_cast<std::int64_t>(i), "point number");
    }
    const double x = reader.number("x");
    const double y = reader.number("y");
    const double z = reader.number("z");
    for (std::size_t a = 0; a < attributes; ++a) reader.number("attribute");
    if (marked) reader.integer("boundary marker");
    reader.end_record();
    builder.add_node(first + static_cast<std::int64_t>(i), {x, y, z}, reader.line());
  }
  refuse_more(reader, points, "points");
  return first;
}

// .ele: `<tetrahedra> <nodes per tetrahedron> <region attribute>`, then `<tetrahedron> <nodes> [attribute]`.
void read_tets(const TetgenText& file, std::int64_t first, MeshBuilder& builder) {
  RecordReader reader(file.text, file.name, '#');
  reader.require_next("the number of tetrahedra");
  const std::size_t tets = reader.count("number of tetrahedra", kBytesPerLine);
  const std::int64_t nodes_each = reader.integer("nodes per tetrahedron");
  if (nodes_each != 4) {
    reader.fail("tetrahedra of " + std::to_string(nodes_each) + " nodes; only linear ones, of 4, are read");
  }
  const bool has_region = read_flag(reader, "region attribute");
  reader.end_record();

  builder.reserve_tets(tets);
  for (std::size_t i = 0; i < tets; ++i) {
    reader.require_next("tetrahedron", i, tets);
    read_number(reader, first + static_cast<std::int64_t>(i), "tetrahedron number");
    std::array<std::int64_t, 4> nodes{};
    for (std::int64_t& node : nodes) node = reader.integer("node");
    const int region = has_region ? reader.small_integer("region attribute") : 0;
    reader.end_record();
    builder.add_tet(nodes, {&region, has_region ? 1U : 0U}, reader.line(), Repeats::refused);
  }
  refuse_more(reader, tets, "tetrahedra");
}

// .face: `<faces> <boundary marker>`, then `<face> <nodes> [marker] [two tetrahedra, as -nn writes]`.
void read_faces(const TetgenText& file, std::int64_t first, MeshBuilder& builder) {
  RecordReader reader(file.text, file.name, '#');
  reader.require_next("the number of faces");
  const std::size_t faces = reader.count("number of faces", kBytesPerLine);
  const bool marked = read_flag(reader, "boundary marker");
  reader.end_record();

  for (std::size_t i = 0; i < faces; ++i) {
    reader.require_next("face", i, faces);
    read_number(reader, first + static_cast<std::int64_t>(i), "face number");
    std::array<std::int64_t, 3> nodes{};
    for (std::int64_t& node : nodes) node = reader.integer("node");
    const int marker = marked ? reader.small_integer("boundary marker") : 0;
    for (int neighbour = 0; neighbour < 2 && reader.has_field(); ++neighbour) reader.integer("neighbour");
    reader.end_record();
    builder.add_triangle(nodes, {&marker, marked ? 1U : 0U}, reader.file(), reader.line());
  }
  refuse_more(reader, faces, "faces");
}

}  // namespace

MeshFile parse_tetgen(const TetgenText& node, const TetgenText& ele, const std::optional<TetgenText>& face) {
  MeshBuilder builder(node.name, ele.name);
  const std::int64_t first = read_nodes(node, builder);
  read_tets(ele, first, builder);
  if (face) read_faces(*face, first, builder);
  return builder.finish(Winding::uniform);
}

}  // namespace tissued::protocol
