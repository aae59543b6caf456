#pragma once

#include <string>

#include "config/bundle.hpp"
#include "core/scene.hpp"
#include "protocol/mesh_file.hpp"

namespace tissued::daemon {

/// The bundle's scene with its mesh: reads bundle.mesh_file and sees to it that every surface that the scene speaks of
/// (fixed, skin, pads) is a group of the mesh. Throws protocol::MeshError or protocol::FileError, which name the file,
/// and the missing group where that is the reason.
core::Scene load_scene(const config::Bundle& bundle);

/// Keeps only the markers of the bundle's set of that name, in the scene's order. Throws config::ConfigError where the
/// bundle has no such set.
void select_markers(core::Scene& scene, const config::Bundle& bundle, const std::string& set);

/// The mesh as core sees it; surfaces in the order of their names. Nodes and tetrahedra keep their indices.
core::TetMesh to_tet_mesh(const protocol::MeshFile& file);

}  // namespace tissued::daemon
