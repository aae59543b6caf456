#include "protocol/mesh_builder.hpp"

#include <algorithm>
#include <utility>

#include "protocol/text_fields.hpp"

namespace tissued::protocol {

namespace {

// The name of a group, or its tag; refused where another group of that kind came by the same name.
template <class Groups>
typename Groups::mapped_type& group_called(Groups& groups, std::map<std::string, int>& tag_of_name, int tag,
                                           const std::map<int, std::string>& names, const std::string& file) {
  const auto named = names.find(tag);
  const std::string name = named == names.end() ? std::to_string(tag) : named->second;
  const int owner = tag_of_name.try_emplace(name, tag).first->second;
  if (owner != tag) {
    throw MeshError(
        file, 0,
        "groups " + std::to_string(owner) + " and " + std::to_string(tag) + " are both called " + in_quotes(name));
  }
  return groups[name];
}

// Puts `tet` in its place of an ascending list, as a rule the last one; false where it is there already.
bool insert_once(std::vector<std::int32_t>& tets, std::int32_t tet) {
  const auto place = tets.empty() || tets.back() < tet ? tets.end() : std::lower_bound(tets.begin(), tets.end(), tet);
  if (place != tets.end() && *place == tet) return false;
  tets.insert(place, tet);
  return true;
}

}  // namespace

MeshBuilder::MeshBuilder(const std::string& node_file, const std::string& tet_file) {
  mesh_.node_file = node_file;
  mesh_.tet_file = tet_file;
}

void MeshBuilder::reserve_nodes(std::size_t count) {
  mesh_.nodes.reserve(count);
  mesh_.node_lines.reserve(count);
  node_of_tag_.reserve(count);
}

void MeshBuilder::reserve_tets(std::size_t count) {
  mesh_.tets.reserve(count);
  mesh_.tet_lines.reserve(count);
  tet_of_nodes_.reserve(count);
}

void MeshBuilder::add_node(std::int64_t tag, const std::array<double, 3>& position, int line) {
  const auto index = static_cast<std::int32_t>(mesh_.nodes.size());
  const auto [earlier, added] = node_of_tag_.try_emplace(tag, index);
  if (!added) {
    throw MeshError(mesh_.node_file, line,
                    "node " + std::to_string(tag) + " was given in line " +
                        std::to_string(mesh_.node_lines[earlier->second]) + " already");
  }
  mesh_.nodes.push_back(position);
  mesh_.node_lines.push_back(line);
}

template <std::size_t kNodes>
std::array<std::int32_t, kNodes> MeshBuilder::indices_of(const std::array<std::int64_t, kNodes>& tags,
                                                         const std::string& file, int line) const {
  std::array<std::int32_t, kNodes> indices{};
  for (std::size_t i = 0; i < kNodes; ++i) {
    const auto node = node_of_tag_.find(tags[i]);
    if (node == node_of_tag_.end()) throw MeshError(file, line, "unknown node " + std::to_string(tags[i]));
    indices[i] = node->second;
    if (std::find(tags.begin(), tags.begin() + i, tags[i]) != tags.begin() + i) {
      throw MeshError(file, line, "node " + std::to_string(tags[i]) + " is named twice in one element");
    }
  }
  return indices;
}

void MeshBuilder::add_tet(const std::array<std::int64_t, 4>& tags, std::span<const int> groups, int line,
                          Repeats repeats) {
  const Tetrahedron nodes = indices_of(tags, mesh_.tet_file, line);
  Tetrahedron sorted = nodes;
  std::sort(sorted.begin(), sorted.end());
  const auto [tet, added] = tet_of_nodes_.try_emplace(sorted, static_cast<std::int32_t>(mesh_.tets.size()));
  if (added) {
    mesh_.tets.push_back(nodes);
    mesh_.tet_lines.push_back(line);
  }
  bool joined = false;
  for (const int group : groups) joined |= insert_once(volumes_[group], tet->second);
  if (!added && (repeats == Repeats::refused || !joined)) {
    throw MeshError(mesh_.tet_file, line,
                    "this tetrahedron repeats the one of line " + std::to_string(mesh_.tet_lines[tet->second]));
  }
}

void MeshBuilder::add_triangle(const std::array<std::int64_t, 3>& tags, std::span<const int> groups,
                               const std::string& file, int line) {
  const Triangle nodes = indices_of(tags, file, line);
  for (const int group : groups) surfaces_[group].push_back(nodes);
}

MeshFile MeshBuilder::finish(Winding winding) {
  if (mesh_.tets.empty()) throw MeshError(mesh_.tet_file, 0, "no tetrahedra");
  check_geometry(mesh_, winding);
  name_groups();
  return std::move(mesh_);
}

void MeshBuilder::name_groups() {
  std::map<std::string, int> tag_of_surface;
  std::map<std::string, int> tag_of_volume;
  for (auto& [tag, triangles] : surfaces_) {
    group_called(mesh_.surfaces, tag_of_surface, tag, surface_names_, mesh_.tet_file) = std::move(triangles);
  }
  for (auto& [tag, tets] : volumes_) {
    group_called(mesh_.volumes, tag_of_volume, tag, volume_names_, mesh_.tet_file) = std::move(tets);
  }
}

std::size_t MeshBuilder::NodesHash::operator()(const Tetrahedron& nodes) const {
  // FNV-1a over the four indices.
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const std::int32_t node : nodes) hash = (hash ^ static_cast<std::uint32_t>(node)) * 0x100000001b3U;
  return hash;
}

}  // namespace tissued::protocol
