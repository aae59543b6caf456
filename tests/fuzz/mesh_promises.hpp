#pragma once

#include "protocol/mesh_check.hpp"
#include "protocol/mesh_file.hpp"
#include "tests/fuzz/promise.hpp"

namespace tissued::fuzz {

// What MeshFile promises of every mesh handed out.
inline void check_mesh(const protocol::MeshFile& mesh) {
  const auto nodes = static_cast<std::int32_t>(mesh.nodes.size());
  const auto known = [&](std::int32_t node) { return node >= 0 && node < nodes; };
  promise(!mesh.tets.empty(), "there are tetrahedra");
  promise(mesh.node_lines.size() == mesh.nodes.size(), "every node has a line");
  promise(mesh.tet_lines.size() == mesh.tets.size(), "every tetrahedron has a line");
  std::vector<bool> used(mesh.nodes.size(), false);
  for (const protocol::Tetrahedron& tet : mesh.tets) {
    for (const std::int32_t node : tet) {
      promise(known(node), "a tetrahedron's nodes are known");
      used[node] = true;
    }
    promise(protocol::signed_volume(mesh.nodes, tet) > 0.0, "volumes are positive");
  }
  for (const bool node : used) promise(node, "every node is used");
  for (const auto& [name, triangles] : mesh.surfaces) {
    promise(!triangles.empty(), "a surface group holds triangles");
    for (const protocol::Triangle& triangle : triangles) {
      for (const std::int32_t node : triangle) promise(known(node), "a triangle's nodes are known");
    }
  }
  for (const auto& [name, tets] : mesh.volumes) {
    promise(!tets.empty(), "a volume group holds tetrahedra");
    for (const std::int32_t tet : tets) {
      promise(tet >= 0 && static_cast<std::size_t>(tet) < mesh.tets.size(), "a group's tetrahedra are known");
    }
  }
}

}  // namespace tissued::fuzz
