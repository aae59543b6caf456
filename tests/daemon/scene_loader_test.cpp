#include "daemon/scene_loader.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/temporary_folder.hpp"

using namespace tissued;
using Catch::Matchers::Contains;

namespace {

// One tetrahedron on a base triangle; its three other faces are skin, one of them a pad's.
const char* const kMesh = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
2 1 "base"
2 2 "skin"
2 3 "A1"
3 4 "tissue"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 10 0 0
3 0 10 0
4 0 0 10
$EndNodes
$Elements
5
1 2 2 1 1 1 3 2
2 2 2 2 2 1 2 4
3 2 2 2 3 1 4 3
4 2 2 3 4 2 3 4
5 4 2 4 5 1 2 3 4
$EndElements
)";

config::Bundle bundle_with(const std::filesystem::path& mesh) {
  config::Bundle bundle;
  bundle.folder = mesh.parent_path();
  bundle.mesh_file = mesh;
  bundle.scene.name = "one tetrahedron";
  bundle.scene.pads.push_back({"P1", "A1", core::Vec3(3, 3, 3), core::Vec3(-1, 0, 0)});
  for (const char* name : {"M1", "M2", "M3"}) bundle.scene.markers.push_back({name, core::Vec3(1, 1, 0)});
  bundle.marker_sets.push_back({"pair", {"M3", "M1"}});
  return bundle;
}

}  // namespace

TEST_CASE("A bundle and its mesh become one scene") {
  const TemporaryFolder folder;
  const auto bundle = bundle_with(folder.write("mesh.msh", kMesh));
  const core::Scene scene = daemon::load_scene(bundle);
  CHECK(scene.name == "one tetrahedron");
  REQUIRE(scene.mesh.node_count() == 4);
  CHECK(scene.mesh.node(3) == core::Vec3(0, 0, 10));
  REQUIRE(scene.mesh.tet_count() == 1);
  CHECK(core::signed_volume(scene.mesh, scene.mesh.tets[0]) > 0);
  REQUIRE(scene.mesh.find_surface("A1") != nullptr);
  CHECK(core::nodes_of(*scene.mesh.find_surface("A1")) == std::vector<int>{1, 2, 3});
  CHECK(core::nodes_of(*scene.mesh.find_surface("base")) == std::vector<int>{0, 1, 2});
}

TEST_CASE("A group that the scene speaks of and the mesh lacks is named, with the file") {
  const TemporaryFolder folder;
  auto bundle = bundle_with(folder.write("mesh.msh", kMesh));
  SECTION("a pad's surface") { bundle.scene.pads[0].surface = "A7"; }
  SECTION("the fixed surface") { bundle.scene.fixed_surface = "A7"; }
  SECTION("the skin") { bundle.scene.skin_surface = "A7"; }
  CHECK_THROWS_WITH(daemon::load_scene(bundle), Contains("mesh.msh") && Contains("A7"));
}

TEST_CASE("A mesh file that is not there is named") {
  const TemporaryFolder folder;
  const auto bundle = bundle_with(folder.path() / "nowhere.msh");
  CHECK_THROWS_WITH(daemon::load_scene(bundle), Contains("nowhere.msh"));
}

TEST_CASE("A marker set keeps the scene's order, an unknown one is refused with the names there are") {
  const TemporaryFolder folder;
  const auto bundle = bundle_with(folder.write("mesh.msh", kMesh));
  core::Scene scene = daemon::load_scene(bundle);
  CHECK_THROWS_WITH(daemon::select_markers(scene, bundle, "trio"), Contains("trio") && Contains("pair"));
  daemon::select_markers(scene, bundle, "pair");
  REQUIRE(scene.markers.size() == 2);
  CHECK(scene.markers[0].name == "M1");
  CHECK(scene.markers[1].name == "M3");
}
