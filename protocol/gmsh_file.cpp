#include "protocol/gmsh_file.hpp"

#include <set>
#include <utility>

#include "protocol/gmsh_sections.hpp"
#include "protocol/text_fields.hpp"

namespace tissued::protocol {

namespace {

enum class Version { v2_2, v4_1 };

// `$MeshFormat`, `<version> <0 for ASCII> <size of a float>`, `$EndMeshFormat`: the first section of any file.
Version read_format(RecordReader& reader) {
  if (!reader.next() || reader.record() != "$MeshFormat")
    reader.fail("not a Gmsh file: it must start with $MeshFormat");
  reader.require_next("the version");
  const std::string version(reader.field("version"));
  const std::int64_t binary = reader.integer("file type");
  if (version != "2.2" && version != "4.1") {
    reader.fail("Gmsh format " + in_quotes(version) + "; only 2.2 and 4.1 are read (gmsh -format msh41)");
  }
  if (binary != 0) reader.fail("a binary Gmsh file; only ASCII is read (gmsh -save -bin 0)");
  reader.integer("data size");
  reader.end_record();
  require_gmsh_end(reader, "$EndMeshFormat");
  return version == "2.2" ? Version::v2_2 : Version::v4_1;
}

// `<names>`, then `<dimension> <tag> "<name>"`.
void read_physical_names(RecordReader& reader, MeshBuilder& builder) {
  reader.require_next("the number of names");
  const std::size_t names = reader.count("number of names", kGmshBytesPerLine);
  reader.end_record();
  std::set<std::pair<int, int>> seen;
  for (std::size_t i = 0; i < names; ++i) {
    require_gmsh_line(reader, "name", i, names);
    const int dimension = reader.small_integer("dimension");
    const int tag = reader.small_integer("physical group");
    const std::string_view name = reader.take_rest();
    if (name.size() < 3 || name.front() != '"' || name.back() != '"') {
      reader.fail("the name must stand in double quotes, not " + in_quotes(name));
    }
    if (!seen.insert({dimension, tag}).second) reader.fail("group " + std::to_string(tag) + " is named twice");
    const std::string bare(name.substr(1, name.size() - 2));
    if (dimension == 2) builder.name_surface(tag, bare);
    if (dimension == 3) builder.name_volume(tag, bare);
  }
  require_gmsh_end(reader, "$EndPhysicalNames");
}

// The current line starts a section: refuses a second one of what there may be one of, and elements whose nodes, or
// entities whose elements, stand on the wrong side of them.
void check_order(const RecordReader& reader, const std::set<std::string>& seen) {
  const std::string section(reader.record());
  const bool single =
      section == "$PhysicalNames" || section == "$Entities" || section == "$Nodes" || section == "$Elements";
  if (single && seen.contains(section)) reader.fail("a second section " + section);
  if (section == "$Elements" && !seen.contains("$Nodes")) reader.fail("$Elements before $Nodes");
  if (section == "$Entities" && seen.contains("$Elements")) reader.fail("$Entities after $Elements");
}

// Sections that hold no geometry, such as $NodeData.
void skip_section(RecordReader& reader) {
  const std::string section(reader.record());
  if (section.size() < 2 || section[0] != '$') reader.fail(in_quotes(section) + " where a section should start");
  const std::string end = "$End" + section.substr(1);
  do {
    reader.require_next(end);
  } while (reader.record() != end);
}

}  // namespace

int gmsh_element_nodes(const RecordReader& reader, int type) {
  switch (type) {
    case 15:
      return 1;
    case 1:
      return 2;
    case 2:
      return 3;
    case 4:
      return 4;
    case 3:
      reader.fail("a quadrangle; only triangles and tetrahedra are read");
    case 5:
      reader.fail("a hexahedron; only triangles and tetrahedra are read");
    case 6:
      reader.fail("a prism; only triangles and tetrahedra are read");
    case 7:
      reader.fail("a pyramid; only triangles and tetrahedra are read");
    case 8:
    case 9:
    case 11:
      reader.fail("a quadratic element (type " + std::to_string(type) + "); only linear ones are read (gmsh -order 1)");
    default:
      reader.fail("an element of type " + std::to_string(type) + "; only linear triangles and tetrahedra are read");
  }
}

void require_gmsh_line(RecordReader& reader, const char* what, std::size_t i, std::size_t count) {
  reader.require_next(what, i, count);
  if (reader.record().starts_with('$')) {
    reader.fail(in_quotes(reader.record()) + " where " + nth_of(what, i, count) + " should be");
  }
}

void require_gmsh_end(RecordReader& reader, const std::string& end) {
  reader.require_next(end);
  if (reader.record() != end) reader.fail(in_quotes(reader.record()) + " where " + end + " should be");
}

MeshFile parse_gmsh(std::string_view text, const std::string& name) {
  RecordReader reader(text, name);
  const Version version = read_format(reader);
  MeshBuilder builder(name, name);
  GmshEntities entities;
  std::set<std::string> seen;
  while (reader.next()) {
    const std::string section(reader.record());
    check_order(reader, seen);
    seen.insert(section);
    if (section == "$PhysicalNames") {
      read_physical_names(reader, builder);
    } else if (section == "$Entities" && version == Version::v4_1) {
      entities = read_gmsh4_entities(reader);
    } else if (section == "$Nodes") {
      version == Version::v2_2 ? read_gmsh2_nodes(reader, builder) : read_gmsh4_nodes(reader, builder);
    } else if (section == "$Elements") {
      version == Version::v2_2 ? read_gmsh2_elements(reader, builder) : read_gmsh4_elements(reader, entities, builder);
    } else {
      skip_section(reader);
    }
  }
  if (!seen.contains("$Elements")) reader.fail("the file ends before $Elements");
  return builder.finish(Winding::positive);
}

}  // namespace tissued::protocol
