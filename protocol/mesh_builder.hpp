#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "protocol/mesh_check.hpp"
#include "protocol/mesh_file.hpp"

namespace tissued::protocol {

/// What a tetrahedron of the same nodes as an earlier one means.
enum class Repeats {
  refused,
  joined,  ///< the earlier one belongs to this group, too: how Gmsh 2.2 writes several groups
};

/// Puts a MeshFile together from nodes and elements as files give them: by tags of any order and with holes. Every
/// refusal is a MeshError at the line handed in.
class MeshBuilder {
 public:
  MeshBuilder(const std::string& node_file, const std::string& tet_file);

  void reserve_nodes(std::size_t count);
  void reserve_tets(std::size_t count);

  /// Refuses a tag that is there already.
  void add_node(std::int64_t tag, const std::array<double, 3>& position, int line);

  /// Adds a tetrahedron to every group of `groups`. Refuses an unknown node, a node named twice, and a repeat.
  void add_tet(const std::array<std::int64_t, 4>& tags, std::span<const int> groups, int line, Repeats repeats);

  /// Adds a triangle to every group of `groups`; without a group its nodes are only checked. `line` counts in `file`.
  void add_triangle(const std::array<std::int64_t, 3>& tags, std::span<const int> groups, const std::string& file,
                    int line);

  /// Names a group; groups without a name are called by their tag in decimal.
  void name_surface(int tag, const std::string& name) { surface_names_[tag] = name; }
  void name_volume(int tag, const std::string& name) { volume_names_[tag] = name; }

  /// The finished mesh, its geometry checked; the builder is spent. Refuses a mesh without tetrahedra.
  MeshFile finish(Winding winding);

 private:
  struct NodesHash {
    std::size_t operator()(const Tetrahedron& nodes) const;
  };

  template <std::size_t kNodes>
  std::array<std::int32_t, kNodes> indices_of(const std::array<std::int64_t, kNodes>& tags, const std::string& file,
                                              int line) const;
  void name_groups();

  MeshFile mesh_;
  std::unordered_map<std::int64_t, std::int32_t> node_of_tag_;
  std::unordered_map<Tetrahedron, std::int32_t, NodesHash> tet_of_nodes_;  // keyed by the sorted nodes
  std::map<int, std::vector<Triangle>> surfaces_;                          // by group tag
  std::map<int, std::vector<std::int32_t>> volumes_;                       // by group tag; each list ascending
  std::map<int, std::string> surface_names_;
  std::map<int, std::string> volume_names_;
};

}  // namespace tissued::protocol
