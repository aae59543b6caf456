// The static answer of admm against FEniCSx's linear tetrahedra (../shared/reference/README.md): the same
// discretisation has the same minimiser.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "config/bundle.hpp"
#include "core/static_solve.hpp"
#include "daemon/scene_loader.hpp"
#include "protocol/displacement_csv.hpp"

namespace {

using namespace tissued;
namespace fs = std::filesystem;

const fs::path kShared = TISSUED_SHARED_DATA;

core::Scene scene_of(const nlohmann::json& asked) {
  const bool dome = asked.at("shape") == "dome";
  config::Bundle bundle = config::load_bundle(kShared / "recordings/paper" / (dome ? "table1" : "gel"));
  bundle.mesh_file = kShared / "reference" / (dome ? "dome.msh" : "box.msh");
  core::Scene scene = daemon::load_scene(bundle);
  scene.material.youngs_modulus = asked.at("physics").at("E");
  scene.material.poissons_ratio = asked.at("physics").at("nu");
  if (asked.at("physics").contains("gravity"))
    for (int axis = 0; axis < 3; ++axis)
      scene.gravity[axis] = asked["physics"]["gravity"][static_cast<std::size_t>(axis)];
  return scene;
}

std::vector<core::PadInput> pads_of(const core::Scene& scene, const nlohmann::json& push) {
  std::vector<core::PadInput> pads(scene.pads.size());
  for (std::size_t p = 0; p < pads.size(); ++p) {
    if (!push.contains(scene.pads[p].name)) continue;
    pads[p].kind = core::PadInput::Kind::pose;
    pads[p].center = scene.pads[p].center + push[scene.pads[p].name].get<double>() * scene.pads[p].direction;
  }
  return pads;
}

double furthest_node(const core::Scene& scene, const core::StaticSolution& solution,
                     const protocol::DisplacementTable& table) {
  double furthest = 0.0;
  for (std::size_t row = 0; row < table.rest.size(); ++row) {
    const core::Vec3 rest(table.rest[row].data()), wanted(table.displacement[row].data());
    Eigen::Index node;
    const double apart = (scene.mesh.rest.rowwise() - rest.transpose()).rowwise().squaredNorm().minCoeff(&node);
    REQUIRE(apart < 1e-8);
    const core::Vec3 moved =
        solution.positions.row(node).head<3>().transpose() - scene.mesh.node(static_cast<int>(node));
    furthest = std::max(furthest, (moved - wanted).norm());
  }
  return furthest;
}

}  // namespace

TEST_CASE("admm meets the reference answers of linear tetrahedra at every node") {
  if (!fs::exists(kShared / "reference/index.json")) {
    WARN("skipped: no reference answers in " << kShared);
    return;
  }
  nlohmann::json index;
  std::ifstream(kShared / "reference/index.json") >> index;
  REQUIRE(index.size() == 5);
  // Whatever the weights start from: where the lightest cycle, the solve must find out of it.
  const double weights = GENERATE(1.0, 4.0);
  for (const auto& [name, asked] : index.items()) {
    INFO(name << ", weights x " << weights);
    const core::Scene scene = scene_of(asked);
    core::StaticOptions options;
    options.weight_scale = weights;
    const nlohmann::json push = asked.value("push", nlohmann::json::object());
    const core::StaticSolution solution = core::solve_static(scene, pads_of(scene, push), options);
    REQUIRE(solution.converged);
    const auto table = protocol::read_displacement_csv(kShared / "reference" / (name + ".csv"));
    CHECK(table.rest.size() == static_cast<std::size_t>(scene.mesh.node_count()));
    CHECK(furthest_node(scene, solution, table) < 1e-3);
    for (const auto& [pad, force] : asked.at("P1").at("pad_force_N").items()) {
      for (std::size_t p = 0; p < scene.pads.size(); ++p) {
        if (scene.pads[p].name != pad) continue;
        for (int axis = 0; axis < 3; ++axis)
          CHECK(solution.pad_forces[p][axis] ==
                Approx(force[static_cast<std::size_t>(axis)].get<double>()).margin(1e-4));
      }
    }
  }
}

TEST_CASE("what cannot converge says so") {
  if (!fs::exists(kShared / "reference/index.json")) {
    WARN("skipped: no reference answers in " << kShared);
    return;
  }
  nlohmann::json index;
  std::ifstream(kShared / "reference/index.json") >> index;
  const auto& asked = index.at("dome-a1-10");
  const core::Scene scene = scene_of(asked);
  core::StaticOptions options;
  options.max_iterations = 3;
  const core::StaticSolution solution = core::solve_static(scene, pads_of(scene, asked.at("push")), options);
  CHECK_FALSE(solution.converged);
  CHECK(solution.trouble.find("not converged after 3 iterations") != std::string::npos);
}
