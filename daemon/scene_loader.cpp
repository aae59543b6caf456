#include "daemon/scene_loader.hpp"

#include <algorithm>

namespace tissued::daemon {

core::TetMesh to_tet_mesh(const protocol::MeshFile& file) {
  core::TetMesh mesh;
  mesh.rest.resize(static_cast<Eigen::Index>(file.nodes.size()), 3);
  for (std::size_t i = 0; i < file.nodes.size(); ++i) {
    mesh.rest.row(static_cast<Eigen::Index>(i)) << file.nodes[i][0], file.nodes[i][1], file.nodes[i][2];
  }
  mesh.tets.assign(file.tets.begin(), file.tets.end());
  for (const auto& [name, triangles] : file.surfaces) {
    mesh.surfaces.push_back({name, {triangles.begin(), triangles.end()}});
  }
  return mesh;
}

core::Scene load_scene(const config::Bundle& bundle) {
  const protocol::MeshFile file = protocol::read_mesh(bundle.mesh_file);
  core::Scene scene = bundle.scene;
  protocol::require_surface(file, scene.fixed_surface);
  protocol::require_surface(file, scene.skin_surface);
  for (const auto& pad : scene.pads) protocol::require_surface(file, pad.surface);
  scene.mesh = to_tet_mesh(file);
  return scene;
}

void select_markers(core::Scene& scene, const config::Bundle& bundle, const std::string& set) {
  const config::MarkerSet* chosen = bundle.find_marker_set(set);
  if (chosen == nullptr) {
    std::string known;
    for (const auto& candidate : bundle.marker_sets) known += (known.empty() ? "" : ", ") + candidate.name;
    throw config::ConfigError((bundle.folder / "bundle.json").string() + ": /marker_sets: there is no set '" + set +
                              "'; there " + (known.empty() ? "is none at all" : "are: " + known));
  }
  std::erase_if(scene.markers, [&](const core::Marker& marker) {
    return std::find(chosen->markers.begin(), chosen->markers.end(), marker.name) == chosen->markers.end();
  });
}

}  // namespace tissued::daemon
