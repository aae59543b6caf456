#include "daemon/explained_model.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "config/bundle.hpp"
#include "config/config_error.hpp"
#include "daemon/scene_loader.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued;

namespace {

core::Scene demo() { return daemon::load_scene(config::load_bundle(TISSUED_SOURCE_DIR "/config/demo")); }

core::Unknown unknown(const std::string& name, double value, core::Unknown::Source source, int fault = 0) {
  core::Unknown out;
  out.name = name;
  out.value = value;
  out.source = source;
  out.fault = fault;
  return out;
}

core::Diagnosis sample(const core::Scene& scene) {
  core::Diagnosis diagnosis;
  diagnosis.bundle = "demo";
  diagnosis.verdict = core::Verdict::missing_physics;
  diagnosis.offset.setZero(core::channels_of(scene).count());
  diagnosis.offset[4] = 0.25;
  core::Fit& fit = diagnosis.explained.exact;
  fit.solved = true;
  fit.hypothesis.effects = {core::find_effect("viscoelasticity")};
  fit.hypothesis.fixed = {{"viscoelasticity.g2", 0.0}, {"viscoelasticity.tau2", 4.0}};
  fit.hypothesis.slips = {{2, 0, 0.5, core::Vec3::Zero()}};
  using Source = core::Unknown::Source;
  fit.unknowns = {unknown("youngs_modulus", 7.5, Source::body), unknown("viscoelasticity.g1", 0.4, Source::body),
                  unknown("viscoelasticity.tau1", 0.6, Source::body), unknown("latency.seconds", 0.05, Source::fault),
                  unknown("marker-slip." + scene.markers[2].name + ".y", 1.5, Source::fault, 8)};
  fit.unknowns.push_back(unknown("release.1", 0.004, Source::fault, -2));
  diagnosis.courses.resize(2);
  diagnosis.courses[0].name = "gravity";
  diagnosis.courses[1].name = "load52";
  diagnosis.explained.hypothesis = fit.hypothesis;
  diagnosis.bundle = scene.name;
  return diagnosis;
}

struct TemporaryFile {
  TemporaryFolder folder;  // tests run side by side
  std::filesystem::path path = folder.path() / "model.json";
};

}  // namespace

TEST_CASE("a model that was written is read back", "[diagnosis]") {
  const core::Scene scene = demo();
  const TemporaryFile file;
  daemon::write_model(sample(scene), scene, file.path);
  const daemon::ExplainedModel model = daemon::read_model(file.path, scene);
  const core::Fit& fit = model.candidate.best();
  REQUIRE(model.candidate.hypothesis.effects.size() == 1);
  CHECK(model.candidate.hypothesis.effects[0]->kind() == "viscoelasticity");
  CHECK(fit.value("youngs_modulus") == 7.5);
  CHECK(fit.value("poissons_ratio") == scene.material.poissons_ratio);
  CHECK(fit.value("viscoelasticity.g1") == 0.4);
  CHECK(fit.value("viscoelasticity.tau2") == 4.0);
  CHECK(fit.value("latency.seconds") == 0.05);
  REQUIRE(model.candidate.hypothesis.slips.size() == 1);
  CHECK(model.candidate.hypothesis.slips[0].marker == 2);
  for (const core::Unknown& number : fit.unknowns)
    if (number.name.starts_with("marker-slip")) CHECK(number.fault == 8);
  CHECK(model.offset[4] == 0.25);
  // When a body was let go is of its recording, not of the body.
  CHECK(model.released == std::map<std::string, double>{{"load52", 0.004}});
  CHECK(!fit.has("release.1"));
}

TEST_CASE("a model that is wrong is refused with file, key and reason", "[diagnosis]") {
  const core::Scene scene = demo();
  const TemporaryFile file;
  daemon::write_model(sample(scene), scene, file.path);
  std::ifstream in(file.path);
  const nlohmann::json good = nlohmann::json::parse(in);
  const auto message_of = [&](const std::string& pointer, const nlohmann::json& value) {
    nlohmann::json bad = good;
    bad[nlohmann::json::json_pointer(pointer)] = value;
    std::ofstream(file.path) << bad.dump();
    try {
      daemon::read_model(file.path, scene);
    } catch (const config::ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  using Catch::Matchers::Contains;
  CHECK_THAT(message_of("/format", "x"), Contains(file.path.string()) && Contains("/format"));
  CHECK_THAT(message_of("/format", 1), Contains(file.path.string()) && Contains("/format"));
  CHECK_THAT(message_of("/bundle", "another"), Contains("/bundle") && Contains("another") && Contains(scene.name));
  CHECK_THAT(message_of("/effects/0/kind", "magic"), Contains("/effects/0/kind") && Contains("magic"));
  CHECK_THAT(message_of("/effects/0/parameters/g1", 7.0), Contains("/effects/0/parameters/g1") && Contains("0.95"));
  CHECK_THAT(message_of("/effects/0/parameters/g1", "a"), Contains("not a number"));
  CHECK_THAT(message_of("/effects", 3), Contains("/effects"));
  CHECK_THAT(message_of("/measurement/slipped", {"M99"}), Contains("M99"));
  CHECK_THAT(message_of("/measurement/numbers/latency.minutes", 1.0), Contains("latency.minutes"));
  CHECK_THAT(message_of("/measurement/released/load52", "late"), Contains("/measurement/released/load52"));
  CHECK_THAT(message_of("/material/youngs_modulus", -1.0), Contains("/material/youngs_modulus"));
  CHECK_THAT(message_of("/marker_offsets/" + scene.markers[0].name, {1.0, 2.0}), Contains("marker_offsets"));
  std::ofstream(file.path) << "{";
  CHECK_THROWS_AS(daemon::read_model(file.path, scene), config::ConfigError);
  CHECK_THROWS_AS(daemon::read_model("/nowhere/model.json", scene), config::ConfigError);
}

TEST_CASE("a configuration that names a model simulates it", "[diagnosis]") {
  const core::Scene scene = demo();
  const TemporaryFile file;
  daemon::write_model(sample(scene), scene, file.path);
  config::DaemonConfig config =
      config::config_for_bundle(TISSUED_SOURCE_DIR "/config/demo", std::vector{"model=" + file.path.string()});
  daemon::apply_model(config);
  CHECK(config.bundle.scene.material.youngs_modulus == 7.5);
  CHECK(config.marker_delay == 0.05);
  CHECK(config.bundle.scene.markers[2].rest.isApprox(scene.markers[2].rest + core::Vec3(0.0, 1.5, 0.0)));
  REQUIRE(config.simulator.effects.size() == 1);
  CHECK(config.simulator.effects[0].effect->kind() == "viscoelasticity");
  CHECK(config.simulator.effects[0].values == std::vector<double>{0.4, 0.6, 0.0, 4.0});
  CHECK(config.marker_correction(core::Vec3(1, 2, 3)).isApprox(core::Vec3(1, 2, 3)));
}

TEST_CASE("the filter supposes as much less as a model leaves less", "[diagnosis]") {
  const core::Scene scene = demo();
  const TemporaryFile file;
  core::Diagnosis diagnosis = sample(scene);
  const auto configured = [&] {
    daemon::write_model(diagnosis, scene, file.path);
    config::DaemonConfig config =
        config::config_for_bundle(TISSUED_SOURCE_DIR "/config/demo", std::vector{"model=" + file.path.string()});
    daemon::apply_model(config);
    return config.simulator.filter;
  };
  const core::FilterOptions usual;
  CHECK(configured().slip == usual.slip);  // no course, no load: nothing is known
  diagnosis.noise_marker_mm = 0.3;
  diagnosis.trials.explained.marker_mm = 0.5;  // 0.4 beyond noise
  diagnosis.courses[0].load = {0.0, 80.0};     // RMS 80 / sqrt(2)
  const double share = 0.4 / (80.0 / std::sqrt(2.0)) / usual.discrepancy;
  REQUIRE(share < 1.0);
  CHECK(configured().slip == Approx(share * usual.slip));
  CHECK(configured().stiffness_sd == Approx(share * usual.stiffness_sd));
  diagnosis.trials.explained.marker_mm = 0.29;  // below noise: never nothing at all
  CHECK(configured().discrepancy == Approx(0.1 * usual.discrepancy));
  diagnosis.trials.explained.marker_mm = 50.0;  // never more than of a body that nobody diagnosed
  CHECK(configured().discrepancy == Approx(usual.discrepancy));
}

TEST_CASE("a faulty registration of the markers is undone", "[diagnosis]") {
  const core::Scene scene = demo();
  const TemporaryFile file;
  core::Diagnosis diagnosis = sample(scene);
  core::Fit& fit = diagnosis.explained.exact;
  fit.unknowns = {unknown("registration.rotation.z", 0.1, core::Unknown::Source::fault, 3),
                  unknown("registration.shift.x", 2.0, core::Unknown::Source::fault, 4)};
  fit.hypothesis = {};
  diagnosis.explained.hypothesis = {};
  daemon::write_model(diagnosis, scene, file.path);
  config::DaemonConfig config =
      config::config_for_bundle(TISSUED_SOURCE_DIR "/config/demo", std::vector{"model=" + file.path.string()});
  daemon::apply_model(config);
  const core::RigidTransform& tissue_from_tracker = config.bundle.tissue_from_tracker;
  const core::Vec3 tissue(10.0, -4.0, 7.0);
  // Turned by 0.1 rad about z, then moved by 2 mm along x.
  const core::Vec3 misplaced(std::cos(0.1) * 10.0 + std::sin(0.1) * 4.0 + 2.0,
                             std::sin(0.1) * 10.0 - std::cos(0.1) * 4.0, 7.0);
  const core::Vec3 seen = tissue_from_tracker.inverse()(misplaced);
  CHECK((tissue_from_tracker(config.marker_correction(seen)) - tissue).norm() < 1e-9);
}
