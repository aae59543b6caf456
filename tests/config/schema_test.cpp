#include "config/schema.hpp"

#include <regex>
#include <set>

#include "config/daemon_config.hpp"
#include "config/validation.hpp"
#include "tests/config/bundle_folder.hpp"

using namespace tissued::config;

namespace {

// Calls `visit` with every node of a schema, and the keyword or key that leads to it.
void each_node(const Json& node, const std::string& place,
               const std::function<void(const Json&, const std::string&)>& visit) {
  visit(node, place);
  for (const char* map : {"properties", "definitions"}) {
    if (!node.contains(map)) continue;
    for (const auto& [name, child] : node[map].items()) each_node(child, place + "/" + map + "/" + name, visit);
  }
  for (const char* child : {"items", "additionalProperties", "propertyNames"}) {
    if (node.contains(child) && node[child].is_object()) each_node(node[child], place + "/" + child, visit);
  }
}

const std::string kConfig = R"({"format": "tissued-config/1", "bundle": "."})";

}  // namespace

TEST_CASE("The schemas built in are the published files") {
  const auto text_of = [](const std::string& name) {
    std::ifstream file(std::string(TISSUED_SOURCE_DIR) + "/config/schema/" + name);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  CHECK((text_of("tissued.schema.json") == config_schema()));  // a failure need not print both
  CHECK((text_of("bundle.schema.json") == bundle_schema()));
}

// The rules of the draft-07 meta-schema for the keywords that the house uses; a keyword outside this list would be
// ignored in silence by validators, so it is an error here.
TEST_CASE("The schemas are valid draft-07") {
  const std::set<std::string> types{"object", "array", "string", "number", "integer", "boolean", "null"};
  const std::set<std::string> texts{"$schema", "$id", "$ref", "title", "description", "pattern"};
  const std::set<std::string> numbers{"minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"};
  const std::set<std::string> counts{"minLength", "maxLength", "minItems", "maxItems", "maxProperties"};
  const std::set<std::string> maps{"properties", "definitions"};
  for (const std::string_view text : {config_schema(), bundle_schema()}) {
    const Json root = parse_json(text, "schema");
    CHECK(root["$schema"] == "http://json-schema.org/draft-07/schema#");
    each_node(root, "", [&](const Json& node, const std::string& place) {
      CAPTURE(place);
      REQUIRE(node.is_object());
      for (const auto& [keyword, value] : node.items()) {
        CAPTURE(keyword);
        if (texts.count(keyword)) {
          CHECK(value.is_string());
        } else if (numbers.count(keyword)) {
          CHECK(value.is_number());
        } else if (counts.count(keyword)) {
          CHECK(value.is_number_unsigned());
        } else if (maps.count(keyword)) {
          CHECK(value.is_object());
        } else if (keyword == "type") {
          const Json list = value.is_array() ? value : Json::array({value});
          for (const Json& type : list) CHECK(types.count(type.get<std::string>()) == 1);
        } else if (keyword == "required") {
          for (const Json& name : value) CHECK(node["properties"].contains(name.get<std::string>()));
        } else if (keyword == "enum") {
          CHECK((value.is_array() && !value.empty()));
        } else if (keyword == "uniqueItems") {
          CHECK(value.is_boolean());
        } else if (keyword == "additionalProperties") {
          CHECK((value.is_object() || value == false));
        } else {
          CHECK((keyword == "items" || keyword == "propertyNames" || keyword == "default" || keyword == "const"));
        }
      }
      if (node.contains("pattern")) CHECK_NOTHROW(std::regex(node["pattern"].get<std::string>()));
      if (node.contains("$ref")) CHECK(root.contains(JsonPointer(node["$ref"].get<std::string>().substr(1))));
      if (node.value("type", Json()) == "object") CHECK(node.contains("additionalProperties"));
    });
  }
}

TEST_CASE("Every key is described, and every number's unit is in the words") {
  const std::regex unit(
      R"(\b(mm2?|s|kPa|N|g/cm3|g|g0|Hz|milliseconds|seconds|frames|no unit|iterations|threads|port|MB|log files|CPU|px|modes|subscriptions)\b|unit vector)",
      std::regex::icase);
  for (const std::string_view text : {config_schema(), bundle_schema()}) {
    const Json root = parse_json(text, "schema");
    each_node(root, "", [&](const Json& node, const std::string& place) {
      if (!node.contains("properties")) return;
      for (const auto& [name, property] : node["properties"].items()) {
        CAPTURE(place, name);
        REQUIRE(property.contains("description"));
        const std::string words = property["description"].get<std::string>();
        CHECK(words.size() >= 3);
        const bool by_reference = property.contains("$ref");
        const Json& target = by_reference ? root[JsonPointer(property["$ref"].get<std::string>().substr(1))] : property;
        if (target.value("items", Json::object()).contains("properties")) continue;  // described one by one
        const std::string dump = target.dump();
        const bool numeric =
            dump.find("\"number\"") != std::string::npos || dump.find("\"integer\"") != std::string::npos;
        if (numeric && !target.contains("properties") && !target.value("additionalProperties", Json()).is_object()) {
          CHECK(std::regex_search(words, unit));
        }
      }
    });
  }
}

TEST_CASE("Every default in a schema fits it, and is what a key left out means") {
  const BundleFolder folder;
  const auto described = [&](const std::string& text) {
    const DaemonConfig config = load_daemon_config(folder.write("config.json", text));
    const auto& s = config.simulator;
    const Json all = {config.tracker.address,
                      config.tracker.port,
                      config.tracker.frame_deadline.count(),
                      config.tracker.subject,
                      config.tracker.peer,
                      config.tracker.peer_port,
                      config.clients.address,
                      config.clients.port,
                      config.clients.max_subscribers,
                      config.clients.lease.count(),
                      config.clients.max_requests_per_s,
                      config.clients.prove_addresses,
                      config.keys.size(),
                      config.record_max_bytes,
                      config.metrics.port.has_value(),
                      s.kind,
                      static_cast<int>(s.solver.scheme),
                      s.solver.iterations,
                      s.solver.tolerance,
                      s.solver.time_step,
                      s.solver.weight_scale,
                      s.solver.threads,
                      static_cast<int>(s.filter.preset),
                      s.filter.process_noise,
                      s.filter.measurement_noise,
                      s.filter.modes,
                      s.filter.stiffness_sd,
                      s.filter.stiffness_length,
                      s.filter.slip,
                      s.filter.discrepancy,
                      static_cast<int>(s.fem.element),
                      s.fem.dynamics.has_value(),
                      s.fem.damping.mass,
                      s.fem.damping.stiffness,
                      s.pbd.particle_spacing,
                      s.pbd.cluster_spacing,
                      s.pbd.cluster_radius,
                      s.pbd.cluster_stiffness,
                      s.pbd.time_step,
                      s.pbd.substeps,
                      s.pbd.iterations,
                      s.pbd.damping,
                      s.pbd.collision_distance,
                      s.pbd.shape_friction,
                      s.pbd.particle_friction,
                      s.pbd.self_collision,
                      static_cast<int>(s.pbd.readout),
                      static_cast<int>(s.rigid.follow),
                      config.registration.fit,
                      config.registration.rest_frames,
                      config.registration.placement_sd,
                      config.registration.rest_tolerance,
                      config.staleness.stale_after.count(),
                      config.staleness.lost_after.count(),
                      config.metrics.port.has_value(),
                      static_cast<int>(config.log.level),
                      config.log.file.string(),
                      config.log.max_bytes,
                      config.log.files,
                      config.realtime.enabled,
                      config.realtime.simulation_cpu.value_or(-1),
                      config.realtime.io_cpu.value_or(-1),
                      config.bundle.scene.markers.size(),
                      config.bundle.scene.material.youngs_modulus,
                      config.bundle.scene.material.poissons_ratio,
                      config.bundle.scene.material.density,
                      config.bundle.scene.gravity.z()};
    return all.dump();
  };
  const std::string left_out = described(kConfig);
  int defaults = 0;
  each_node(Json::parse(config_schema()), "", [&](const Json& node, const std::string& place) {
    if (!node.contains("default")) return;
    CAPTURE(place);
    ++defaults;
    const std::string key = std::regex_replace(place, std::regex("/properties"), "");
    CHECK(described(with(kConfig, key, node["default"].dump())) == left_out);
  });
  CHECK(defaults == 70);
}

TEST_CASE("The simulators that the schema offers are those that core makes") {
  const Json schema = Json::parse(config_schema());
  const auto names = tissued::core::simulator_names();
  CHECK(schema[JsonPointer("/properties/simulator/properties/kind/enum")] ==
        Json(std::vector<std::string>(names.begin(), names.end())));
}

// valijson's verdict and the words found for it must never disagree; most mutations break the document somewhere.
TEST_CASE("Whatever valijson refuses has words, and nothing else has") {
  const Json values =
      Json::parse(R"([null, true, 0, -1, 1.5, 1e9, 10.0, -1.0, 0.5, "", "x", "all", "\u0007", "a\nb", "a\n",
    "0123456789012345678901234", [], [0, 0, 0], [0, 0], ["M1", "M1"], {}, {"x": 1}])");
  int refused = 0, accepted = 0;
  const auto try_all = [&](const std::string& document, std::string_view schema) {
    const Json schema_json = Json::parse(schema);
    std::set<std::string> places;
    const Json flat = Json::parse(document).flatten();
    for (const auto& [key, ignored] : flat.items()) {
      for (JsonPointer place(key); !place.empty(); place.pop_back()) places.insert(place.to_string());
    }
    for (const std::string& place : places) {
      for (const Json& value : values) {
        const Json mutated = Json::parse(with(document, place, value.dump()));
        const auto violation = validate(mutated, schema);
        CAPTURE(place, value.dump());
        REQUIRE(violation.has_value() == find_violation(mutated, schema_json).has_value());
        ++(violation ? refused : accepted);
        if (violation) REQUIRE(violation->reason != "does not fit the schema");
      }
    }
  };
  try_all(
      R"({"format": "tissued-config/1", "bundle": ".", "tracker": {"port": 1, "frame_deadline_ms": 2, "subject": "p"},
    "simulator": {"kind": "admm", "iterations": 3, "tolerance": 0.1, "time_step": 0.01}, "gravity": [0, 0, 1],
    "material": {"poissons_ratio": 0.3}, "markers": ["M1", "M2"], "registration": {"fit": true}})",
      config_schema());
  try_all(kFullBundle, bundle_schema());
  CHECK(refused > 1000);
  CHECK(accepted > 100);
}
