#include <cstdlib>

#include "protocol/gmsh_sections.hpp"

namespace tissued::protocol {

namespace {

constexpr std::array<const char*, 4> kEntityNames{"point", "curve", "surface", "volume"};

// `<number of groups> <group> ...`; a negative tag means an entity that is turned over.
std::vector<int> read_groups(RecordReader& reader) {
  // Every element of the entity is kept once in each: more would let a small file fill the memory.
  constexpr std::size_t kMostGroups = 64;
  const std::size_t count = reader.count("number of physical groups", 2);
  if (count > kMostGroups)
    reader.fail("the entity is in " + std::to_string(count) + " physical groups, more than " +
                std::to_string(kMostGroups));
  std::vector<int> groups(count);
  for (int& group : groups) group = std::abs(reader.small_integer("physical group"));
  return groups;
}

// `<tag> <3 or 6 bounds> <number of groups> <groups> [<number of boundary entities> <entities>]`
void read_entity(RecordReader& reader, int dimension, GmshEntities& entities) {
  const int tag = reader.small_integer("entity tag");
  for (int i = 0; i < (dimension == 0 ? 3 : 6); ++i) reader.number("bound of the entity");
  std::vector<int> groups = read_groups(reader);
  if (dimension > 0) {
    const std::size_t boundaries = reader.count("number of boundary entities", 2);
    for (std::size_t i = 0; i < boundaries; ++i) reader.small_integer("boundary entity");
  }
  reader.end_record();
  if (dimension < 2) return;
  auto& known = dimension == 2 ? entities.surfaces : entities.volumes;
  if (!known.emplace(tag, std::move(groups)).second) reader.fail("entity " + std::to_string(tag) + " is given twice");
}

// `<entity dimension> <entity tag> <parametric, or element type> <count>`, the first line of a block.
struct Block {
  int dimension;
  int entity;
  int kind;
  std::size_t count;
};

Block read_block_line(RecordReader& reader, const char* kind, const char* count, std::size_t bytes_each) {
  Block block{};
  block.dimension = reader.small_integer("entity dimension");
  block.entity = reader.small_integer("entity tag");
  block.kind = reader.small_integer(kind);
  block.count = reader.count(count, bytes_each);
  reader.end_record();
  if (block.dimension < 0 || block.dimension > 3) {
    reader.fail("entity dimension " + std::to_string(block.dimension) + " is not 0 to 3");
  }
  return block;
}

struct SectionCounts {
  std::size_t blocks;
  std::size_t entries;
};

// `<blocks> <nodes or elements> <least tag> <greatest tag>`
SectionCounts read_section_line(RecordReader& reader, const char* entries) {
  reader.require_next(entries);
  SectionCounts counts{};
  counts.blocks = reader.count("number of blocks", kGmshBytesPerLine);
  counts.entries = reader.count(entries, kGmshBytesPerLine);
  reader.integer("least tag");
  reader.integer("greatest tag");
  reader.end_record();
  return counts;
}

void require_entries(const RecordReader& reader, std::size_t held, std::size_t said, const char* what) {
  if (held == said) return;
  reader.fail("the blocks hold " + std::to_string(held) + " " + what + ", the section says " + std::to_string(said));
}

// A block of nodes: all tags first, one a line, then all positions, `<x> <y> <z>` with parameters of the entity behind
// where the block is parametric.
void read_node_block(RecordReader& reader, const Block& block, MeshBuilder& builder) {
  std::vector<std::int64_t> tags(block.count);
  for (std::size_t i = 0; i < block.count; ++i) {
    require_gmsh_line(reader, "tag of node", i, block.count);
    tags[i] = reader.integer("node tag");
    reader.end_record();
  }
  for (std::size_t i = 0; i < block.count; ++i) {
    require_gmsh_line(reader, "position of node", i, block.count);
    const double x = reader.number("x");
    const double y = reader.number("y");
    const double z = reader.number("z");
    for (int p = 0; block.kind == 1 && p < block.dimension; ++p) reader.number("parameter");
    reader.end_record();
    builder.add_node(tags[i], {x, y, z}, reader.line());
  }
}

// The physical groups of the entity that a block of triangles or tetrahedra lies on.
std::span<const int> groups_of(const RecordReader& reader, const GmshEntities& entities, const Block& block) {
  if (!entities.given) return {};
  const auto& known = block.dimension == 2 ? entities.surfaces : entities.volumes;
  const auto entity = known.find(block.entity);
  if (entity == known.end()) {
    reader.fail("entity " + std::to_string(block.entity) + " of dimension " + std::to_string(block.dimension) +
                " is not in $Entities");
  }
  return entity->second;
}

// `<element> <nodes>` a line
void read_element_block(RecordReader& reader, const Block& block, const GmshEntities& entities, MeshBuilder& builder) {
  const int nodes = gmsh_element_nodes(reader, block.kind);
  if (block.dimension != nodes - 1) {
    reader.fail("elements of type " + std::to_string(block.kind) + " on an entity of dimension " +
                std::to_string(block.dimension));
  }
  const auto groups = block.dimension < 2 ? std::span<const int>{} : groups_of(reader, entities, block);
  for (std::size_t i = 0; i < block.count; ++i) {
    require_gmsh_line(reader, "element", i, block.count);
    reader.integer("element number");
    std::array<std::int64_t, 4> tags{};
    for (int n = 0; n < nodes; ++n) tags[n] = reader.integer("node");
    reader.end_record();
    if (nodes == 3) builder.add_triangle({tags[0], tags[1], tags[2]}, groups, reader.file(), reader.line());
    if (nodes == 4) builder.add_tet(tags, groups, reader.line(), Repeats::refused);
  }
}

}  // namespace

GmshEntities read_gmsh4_entities(RecordReader& reader) {
  reader.require_next("the numbers of entities");
  std::array<std::size_t, 4> counts{};
  for (std::size_t& count : counts) count = reader.count("number of entities", kGmshBytesPerLine);
  reader.end_record();
  GmshEntities entities;
  entities.given = true;
  for (int dimension = 0; dimension < 4; ++dimension) {
    for (std::size_t i = 0; i < counts[dimension]; ++i) {
      require_gmsh_line(reader, kEntityNames[dimension], i, counts[dimension]);
      read_entity(reader, dimension, entities);
    }
  }
  require_gmsh_end(reader, "$EndEntities");
  return entities;
}

void read_gmsh4_nodes(RecordReader& reader, MeshBuilder& builder) {
  const SectionCounts counts = read_section_line(reader, "number of nodes");
  builder.reserve_nodes(counts.entries);
  std::size_t held = 0;
  for (std::size_t i = 0; i < counts.blocks; ++i) {
    require_gmsh_line(reader, "node block", i, counts.blocks);
    const Block block = read_block_line(reader, "parametric", "number of nodes in the block", 2 * kGmshBytesPerLine);
    if (block.kind != 0 && block.kind != 1) {
      reader.fail("parametric must be 0 or 1, not " + std::to_string(block.kind));
    }
    held += block.count;
    read_node_block(reader, block, builder);
  }
  require_gmsh_end(reader, "$EndNodes");
  require_entries(reader, held, counts.entries, "nodes");
}

void read_gmsh4_elements(RecordReader& reader, const GmshEntities& entities, MeshBuilder& builder) {
  const SectionCounts counts = read_section_line(reader, "number of elements");
  builder.reserve_tets(counts.entries);
  std::size_t held = 0;
  for (std::size_t i = 0; i < counts.blocks; ++i) {
    require_gmsh_line(reader, "element block", i, counts.blocks);
    const Block block = read_block_line(reader, "element type", "number of elements in the block", kGmshBytesPerLine);
    held += block.count;
    read_element_block(reader, block, entities, builder);
  }
  require_gmsh_end(reader, "$EndElements");
  require_entries(reader, held, counts.entries, "elements");
}

}  // namespace tissued::protocol
