#include "daemon/evaluated_model.hpp"

#include <catch2/catch.hpp>

#include "config/daemon_config.hpp"
#include "core/simulator.hpp"
#include "daemon/ctl_options.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

config::DaemonConfig config_of(const std::string& model) {
  return config::config_for_bundle(TISSUED_SOURCE_DIR "/config/demo", named_model(model).overrides);
}

}  // namespace

TEST_CASE("Every simulator is a model, everything else at its default") {
  for (const std::string_view name : core::simulator_names()) {
    const config::DaemonConfig config = config_of(std::string(name));
    CHECK(config.simulator.kind == name);
    CHECK(config.simulator.filter.preset == core::NoisePreset::standard);
    CHECK(config.simulator.solver.scheme == core::Scheme::per_frame);
    CHECK(config.simulator.solver.element == core::Element::smoothed);
  }
}

TEST_CASE("The paper's models are as the paper prints them") {
  const config::DaemonConfig closed = config_of("paper"), open = config_of("paper-admm");
  CHECK(closed.simulator.kind == "kf-admm");
  CHECK(closed.simulator.filter.preset == core::NoisePreset::paper);
  CHECK(open.simulator.kind == "admm");
  for (const auto* config : {&closed, &open}) {
    CHECK(config->simulator.solver.scheme == core::Scheme::algorithm_1);
    CHECK(config->simulator.solver.element == core::Element::p1);
  }
}

TEST_CASE("A model that there is not is refused, with those that there are") {
  CHECK_THROWS_WITH(named_model("magic"),
                    Catch::Contains("`magic`") && Catch::Contains("kf-admm") && Catch::Contains("paper-admm"));
  for (const std::string& name : model_names()) CHECK(named_model(name).name == name);
}

TEST_CASE("A variant is a name and keys, and commas inside of brackets are part of a value") {
  const EvaluatedModel model = parse_variant("heavy:gravity=[0,0,-1],simulator.kind=admm,markers=[\"M1\",\"M2\"]");
  CHECK(model.name == "heavy");
  CHECK(model.overrides ==
        std::vector<std::string>{"gravity=[0,0,-1]", "simulator.kind=admm", "markers=[\"M1\",\"M2\"]"});
}

TEST_CASE("A variant by a file is all that the configuration says beside its bundle") {
  const TemporaryFolder folder;
  const auto file = folder.write("tuned.json", R"({"format": "tissued-config/1", "bundle": "/nowhere",
    "simulator": {"kind": "pbd", "pbd": {"cluster_spacing": 9.5}}, "markers": ["M1", "M2"]})");
  const EvaluatedModel model = parse_variant("tuned:" + file.string());
  CHECK(model.name == "tuned");
  CHECK(model.overrides == std::vector<std::string>{"simulator.kind=\"pbd\"", "simulator.pbd.cluster_spacing=9.5",
                                                    "markers=[\"M1\",\"M2\"]"});
  CHECK_THROWS_AS(parse_variant("tuned:" + (folder.path() / "missing.json").string()), config::ConfigError);
}

TEST_CASE("What is no variant is refused") {
  for (const char* text : {"", ":", "name", ":a=1", "name:", "name:a", "name:a=1,", "name:=1", "name:a=1,,b=2"}) {
    INFO(text);
    CHECK_THROWS_AS(parse_variant(text), UsageError);
  }
}
