#include "daemon/diagnosis_json.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/daemon/diagnosis_samples.hpp"

using namespace tissued;
using daemon::report_json;
using nlohmann::json;

TEST_CASE("A report has the contract's names and numbers") {
  const json report = report_json(daemon::inclusion_sample(daemon::demo_scene()));
  CHECK(report["format"] == "tissue-diagnosis/1");
  CHECK(report["bundle"] == "demo");
  CHECK(report["verdict"] == "missing-physics");
  CHECK(report["seconds"] == 41.3);
  CHECK(report["complete"] == true);
  CHECK(report["next_experiment"].is_string());
  REQUIRE(report["findings"].size() == 1);
  CHECK(report["findings"][0] == json::parse(R"({
    "kind": "inclusion", "probability": 0.968,
    "summary": "A lump of 11 mm radius around (24, 6, 30) mm is 4.2 times as stiff as the tissue around it.",
    "where": {"center": [24.0, 6.0, 30.0], "radius": 11.0}, "when": {"trials": ["a1-14"], "phase": "hold"},
    "parameters": {"center": {"value": [24.0, 6.0, 30.0], "sd": [0.9, 1.1, 1.6], "unit": "mm"},
                   "radius": {"value": 11.2, "sd": 0.8, "unit": "mm"},
                   "ratio": {"value": 4.2, "sd": 0.7, "unit": "1"}}})"));
  REQUIRE(report["each_trial"].size() == 4);
  CHECK(report["each_trial"][3]["trial"] == "held-a12-10");
  CHECK(report["each_trial"][3]["held_out"] == true);
  CHECK(report["each_trial"][0]["assumed_marker_rms"].get<double>() == Approx(0.787).margin(1e-3));
  REQUIRE(report["alternatives"].size() == 4);
  CHECK(report["alternatives"][0] == json{{"kind", "stiffness-gradient"}, {"probability", 0.021}});
  CHECK(report["fit"] == json::parse(R"({
    "trials":   {"assumed":    {"marker_rms": 0.81, "target_rms": 0.66, "force_rms": 0.21},
                 "parameters": {"marker_rms": 0.54, "target_rms": 0.47, "force_rms": 0.12},
                 "explained":  {"marker_rms": 0.122, "target_rms": 0.31, "force_rms": 0.013}},
    "held_out": {"assumed":    {"marker_rms": 0.74, "target_rms": 0.62},
                 "parameters": {"marker_rms": 0.55, "target_rms": 0.49},
                 "explained":  {"marker_rms": 0.128, "target_rms": 0.32}},
    "noise_floor": {"marker": 0.1, "force": 0.012}, "discretisation": {"marker_rms": 0.06}})"));
}

TEST_CASE("What was not seen has no key, and what has no place is null") {
  core::Diagnosis diagnosis = daemon::no_mismatch_sample(daemon::demo_scene());
  core::Finding finding;
  finding.kind = "latency";
  finding.parameters = {{"seconds", "s", {0.04}, {NAN}}, {"shift", "mm", {NAN}, {0.1}}, {"nothing", "", {}, {}}};
  diagnosis.findings = {finding};
  const json report = report_json(diagnosis);
  CHECK(report["verdict"] == "no-mismatch");
  CHECK(report["next_experiment"].is_null());
  CHECK(report["findings"][0]["where"].is_null());
  CHECK_FALSE(report["findings"][0]["when"].contains("phase"));
  CHECK(report["findings"][0]["parameters"] ==
        json::parse(R"({"seconds": {"value": 0.04, "unit": "s"}, "shift": {"sd": 0.1, "unit": "mm"},
                        "nothing": {"unit": ""}})"));
  CHECK(report["fit"]["trials"]["assumed"] == json{{"marker_rms", 0.104}});
  CHECK(report["fit"]["held_out"] == json::parse(R"({"assumed": {}, "parameters": {}, "explained": {}})"));
  CHECK(report["fit"]["noise_floor"] == json{{"marker", 0.1}});
}

TEST_CASE("Numbers of held-out recordings that were not seen do not slip into the report") {
  core::Diagnosis diagnosis = daemon::inclusion_sample(daemon::demo_scene());
  diagnosis.held_out_seen = false;
  CHECK(report_json(diagnosis)["fit"]["held_out"]["explained"].empty());
}

TEST_CASE("A finding without parameters and a report without findings keep their shape") {
  const core::Diagnosis nothing;
  CHECK(report_json(nothing)["findings"] == json::array());
  CHECK(report_json(nothing)["alternatives"] == json::array());
  core::Diagnosis one;
  one.findings.emplace_back();
  CHECK(report_json(one)["findings"][0]["parameters"] == json::object());
}

TEST_CASE("Every verdict has the contract's name") {
  using core::Verdict;
  const std::pair<Verdict, const char*> names[]{{Verdict::no_mismatch, "no-mismatch"},
                                                {Verdict::parameters, "parameters"},
                                                {Verdict::measurement, "measurement"},
                                                {Verdict::missing_physics, "missing-physics"},
                                                {Verdict::unexplained, "unexplained"}};
  core::Diagnosis diagnosis;
  for (const auto& [verdict, name] : names) {
    diagnosis.verdict = verdict;
    CHECK(report_json(diagnosis)["verdict"] == name);
  }
}

TEST_CASE("A slipped marker is named, as the contract has it") {
  core::Diagnosis diagnosis = daemon::inclusion_sample(daemon::demo_scene());
  core::Finding& finding = diagnosis.findings.at(0);
  finding.kind = "marker-slip";
  finding.parameters = {{"M07", "mm", {1.0, 0.5, -0.25}, {0.1, 0.2, 0.3}}};
  CHECK(report_json(diagnosis)["findings"][0]["parameters"] == json::parse(R"({
    "markers": {"value": ["M07"]},
    "shift": {"value": [1.0, 0.5, -0.25], "sd": [0.1, 0.2, 0.3], "unit": "mm"}})"));
  finding.parameters.push_back({"M09", "mm", {0.0, 2.0, 0.0}, {0.1, 0.1, 0.1}});
  const json two = report_json(diagnosis)["findings"][0]["parameters"];
  CHECK(two["markers"]["value"] == json::parse(R"(["M07", "M09"])"));
  CHECK(two["shift"]["value"] == json::parse("[[1.0, 0.5, -0.25], [0.0, 2.0, 0.0]]"));
}
