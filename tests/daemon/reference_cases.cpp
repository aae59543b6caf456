#include "tests/daemon/reference_cases.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "config/bundle.hpp"
#include "daemon/scene_loader.hpp"
#include "protocol/displacement_csv.hpp"

namespace tissued::daemon::testing {

namespace {

namespace fs = std::filesystem;

const fs::path kShared = TISSUED_SHARED_DATA;

// The reference moved a point that the faceted dome cuts off towards the dome's middle until it lay inside: found from
// its P1 displacements, which give the place of every marker to five digits.
core::Vec3 moved_inside(const core::TetMesh& mesh, const core::Vec3& point) {
  constexpr double kStep = 5e-4;
  const core::Vec3 middle(0.0, 0.0, 15.0);
  for (int k = 0; k < 100; ++k) {
    const core::Vec3 place = point + k * kStep * (middle - point);
    if (core::locate_in_volume(mesh, place).distance == 0.0) return place;
  }
  return point;
}

}  // namespace

nlohmann::json reference_index() {
  nlohmann::json index;
  if (!fs::exists(kShared / "reference/index.json")) {
    WARN("skipped: no reference answers in " << kShared);
    return index;
  }
  std::ifstream(kShared / "reference/index.json") >> index;
  return index;
}

core::Scene reference_scene(const nlohmann::json& asked) {
  const bool dome = asked.at("shape") == "dome";
  config::Bundle bundle = config::load_bundle(kShared / "recordings/paper" / (dome ? "table1" : "gel"));
  bundle.mesh_file = kShared / "reference" / (dome ? "dome.msh" : "box.msh");
  core::Scene scene = load_scene(bundle);
  scene.material.youngs_modulus = asked.at("physics").at("E");
  scene.material.poissons_ratio = asked.at("physics").at("nu");
  if (asked.at("physics").contains("gravity"))
    for (int axis = 0; axis < 3; ++axis)
      scene.gravity[axis] = asked["physics"]["gravity"][static_cast<std::size_t>(axis)];
  if (dome) {
    for (core::Marker& marker : scene.markers) marker.rest = moved_inside(scene.mesh, marker.rest);
  } else {
    // The box's targets are not those of the gel bundle; these places follow from their P1 displacements in two cases.
    scene.targets.at(1).rest = {38.0, 12.0, 53.0};
    scene.targets.at(2).rest = {-38.0, -12.0, 40.0};
  }
  return scene;
}

std::vector<core::PadInput> reference_pads(const core::Scene& scene, const nlohmann::json& asked) {
  const nlohmann::json push = asked.value("push", nlohmann::json::object());
  std::vector<core::PadInput> pads(scene.pads.size());
  for (std::size_t p = 0; p < pads.size(); ++p) {
    if (!push.contains(scene.pads[p].name)) continue;
    pads[p].kind = core::PadInput::Kind::pose;
    pads[p].center = scene.pads[p].center + push[scene.pads[p].name].get<double>() * scene.pads[p].direction;
  }
  return pads;
}

double furthest_from_reference(const core::Scene& scene, const Eigen::MatrixX3d& moved, const std::string& name) {
  const auto table = protocol::read_displacement_csv(kShared / "reference" / (name + ".csv"));
  REQUIRE(table.rest.size() == static_cast<std::size_t>(scene.mesh.node_count()));
  double furthest = 0.0;
  for (std::size_t row = 0; row < table.rest.size(); ++row) {
    const core::Vec3 rest(table.rest[row].data()), wanted(table.displacement[row].data());
    Eigen::Index node;
    const double apart = (scene.mesh.rest.rowwise() - rest.transpose()).rowwise().squaredNorm().minCoeff(&node);
    REQUIRE(apart < 1e-8);
    furthest = std::max(furthest, (moved.row(node).transpose() - wanted).norm());
  }
  return furthest;
}

double worst_force(const core::Scene& scene, const std::vector<core::Vec3>& pad_forces, const nlohmann::json& answer) {
  double worst = 0.0;
  for (const auto& [name, force] : answer.at("pad_force_N").items())
    for (std::size_t p = 0; p < scene.pads.size(); ++p)
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (scene.pads[p].name == name)
          worst = std::max(worst, std::abs(pad_forces[p][static_cast<int>(axis)] - force[axis].get<double>()));
  return worst;
}

}  // namespace tissued::daemon::testing
