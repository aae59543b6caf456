#include "daemon/diagnosis_page.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "daemon/body_slices.hpp"
#include "daemon/diagnosis_words.hpp"
#include "daemon/mismatch_field.hpp"
#include "tests/daemon/diagnosis_samples.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued;
using namespace tissued::daemon;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

std::size_t count(std::string_view text, std::string_view what) {
  std::size_t found = 0;
  for (auto at = text.find(what); at != std::string_view::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

std::string between(const std::string& text, const std::string& begin, const std::string& end) {
  const auto from = text.find(begin);
  REQUIRE(from != std::string::npos);
  return text.substr(from + begin.size(), text.find(end, from) - from - begin.size());
}

json viewer_data(const std::string& page) {
  return json::parse(between(page, "<script type=\"application/json\" id=\"body-data\">", "</script>"));
}

// The page without its scripts, as Python's XML parser reads it: tags are closed, names and attributes are escaped.
bool is_well_formed(std::string page) {
  const auto drop = [&](const std::string& begin, const std::string& end) {
    for (auto from = page.find(begin); from != std::string::npos; from = page.find(begin)) {
      page.erase(from, page.find(end, from) + end.size() - from);
    }
  };
  drop("<script", "</script>");
  for (auto at = page.find(" selected>"); at != std::string::npos; at = page.find(" selected>")) page.erase(at, 9);
  const TemporaryFolder folder;
  const auto file = folder.write("report.html", page);
  const std::string command = std::string(TISSUED_PYTHON) +
                              " -c 'import sys, xml.etree.ElementTree as E; E.parse(sys.argv[1])' " + file.string();
  return std::system(command.c_str()) == 0;
}

}  // namespace

TEST_CASE("A page of a diagnosis is well-formed, loads nothing, and says what it is not") {
  const core::Scene scene = demo_scene();
  for (const auto& sample : {inclusion_sample, no_mismatch_sample, unexplained_sample}) {
    const std::string page = diagnosis_page(sample(scene), scene);
    CHECK(is_well_formed(page));
    CHECK_THAT(page, Contains("not a medical device") && Contains("@media print") && Contains("width=device-width"));
    for (const char* loads : {"http:", "https:", "src=", "href=", "url(", "@import", "<link", "fetch(", "import(",
                              "XMLHttpRequest", ">nan", "nan,", "\"nan", ">inf", "inf,"}) {
      INFO(loads);
      CHECK(page.find(loads) == std::string::npos);
    }
  }
}

TEST_CASE("The first words say what is wrong, how sure that is and where") {
  const core::Scene scene = demo_scene();
  const std::string page = diagnosis_page(inclusion_sample(scene), scene);
  CHECK(between(page, "<h1>", "</h1>") == "There is a lump of other stiffness in the tissue.");
  CHECK_THAT(page, Contains("97 % sure") && Contains("24 mm from the skin") && Contains("from pad A1") &&
                       Contains("from target T1") && Contains("Push A3 by 14 mm"));
  CHECK_THAT(page, Contains("4.2 ± 0.7") && Contains("24.0 ± 0.9, 6.0 ± 1.1, 30.0 ± 1.6"));
  CHECK_THAT(page, Contains("0.740") && Contains("0.128"));  // held out: as assumed and explained
  CHECK_THAT(page, !Contains("stopped before its end"));

  const std::string null_page = diagnosis_page(no_mismatch_sample(scene), scene);
  CHECK(between(null_page, "<h1>", "</h1>") == "The simulation explains what was recorded.");
  CHECK_THAT(null_page, Contains("No fault is likelier than 1.2 % (parameters)") && !Contains("<h2>Forces") &&
                            !Contains("Cuts through the place") && !Contains("What to record next") &&
                            !Contains("held out: predicted"));

  const std::string unknown_page = diagnosis_page(unexplained_sample(scene), scene);
  CHECK_THAT(unknown_page, Contains("91 % sure") && Contains("Around (-20, 10, 22) mm, within 16 mm") &&
                               Contains("stopped before its end"));
}

TEST_CASE("Several findings make one sentence, and uncertain ones are not in it") {
  core::Diagnosis diagnosis;
  diagnosis.verdict = core::Verdict::missing_physics;
  core::Finding finding;
  const auto add = [&](const char* kind, const char* title, double probability) {
    finding.kind = kind;
    finding.title = title;
    finding.probability = probability;
    diagnosis.findings.push_back(finding);
  };
  add("parameters", "The tissue's own numbers are other than assumed", 0.99);
  CHECK(headline(diagnosis) == "The tissue's own numbers are other than assumed");
  add("inclusion", "There is a lump", 0.9);
  add("viscoelasticity", "The tissue relaxes", 0.8);
  add("skin", "A skin covers it", 0.3);
  CHECK(headline(diagnosis) == "There is a lump, and the tissue relaxes");
  CHECK_THAT(sureness_text(diagnosis), Contains("90 % sure of inclusion") && !Contains("skin"));
}

TEST_CASE("Probabilities and numbers are said with the digits that they have") {
  CHECK(percent_text(1.0) == "over 99 %");
  CHECK(percent_text(0.994) == "99 %");
  CHECK(percent_text(0.5) == "50 %");
  CHECK(percent_text(0.021) == "2.1 %");
  CHECK(percent_text(0.0) == "under 0.1 %");
  CHECK(percent_text(NAN) == "–");
  CHECK(number_text({"g1", "1", {0.4836}, {0.0213}}) == "0.484 ± 0.021");
  CHECK(number_text({"E", "kPa", {1234.5}, {87.0}}) == "1234 ± 87");
  CHECK(number_text({"x", "", {0.25}, {NAN}}) == "0.25");
  CHECK(number_text({"x", "", {NAN, 2.0}, {0.1}}) == "–, 2");
  CHECK(number_text({"x", "", {}, {}}).empty());
}

TEST_CASE("Names cannot break out of the page of a diagnosis") {
  core::Scene scene = demo_scene();
  const std::string evil = "</script><script>alert(\"1\")</script>&";
  scene.pads[0].name = scene.targets[0].name = scene.markers[0].name = scene.name = evil;
  core::Diagnosis diagnosis = inclusion_sample(scene);
  diagnosis.next_experiment = evil;
  diagnosis.remarks = {evil};
  diagnosis.alternatives[0].kind = evil;
  core::Finding& finding = diagnosis.findings[0];
  finding.kind = finding.title = finding.summary = finding.phase = evil;
  finding.trials = {evil};
  finding.parameters[0].name = finding.parameters[0].unit = evil;
  for (core::TrialCourse& course : diagnosis.courses) course.name = evil;
  for (core::MarkerMisfit& marker : diagnosis.markers) marker.trial = evil;
  const std::string page = diagnosis_page(diagnosis, scene);
  CHECK(count(page, "<script") == 2);  // the viewer and what it draws
  CHECK(count(page, "alert(\"1\")") == 0);
  CHECK(is_well_formed(page));
  CHECK(viewer_data(page)["pads"][0]["name"] == evil);
}

TEST_CASE("The viewer is given the body's surface and what was seen of it") {
  const core::Scene scene = demo_scene();
  const json data = viewer_data(diagnosis_page(inclusion_sample(scene), scene));
  CHECK(data["triangles"].size() == 3 * (256 + 224 + 4 * 8));
  CHECK(data["groups"].size() == 256 + 224 + 4 * 8);
  CHECK(std::ranges::count(data["groups"], json(1)) == 4 * 8);
  CHECK(std::ranges::count(data["groups"], json(2)) == 256);
  for (const json& corner : data["triangles"]) REQUIRE(corner < data["points"].size() / 3);
  CHECK(data["trials"].size() == 4);
  CHECK(data["trials"][0]["markers"].size() == scene.markers.size());
  CHECK(data["places"] == json::parse(R"([{"center": [24.0, 6.0, 30.0], "radius": 11.0, "label": "inclusion"}])"));
  const json& map = data["map"];
  const std::size_t samples =
      map["size"][0].get<std::size_t>() * map["size"][1].get<std::size_t>() * map["size"][2].get<std::size_t>();
  CHECK(map["values"].get<std::string>().size() == 4 * ((samples + 2) / 3));  // base64
  CHECK(viewer_data(diagnosis_page(no_mismatch_sample(scene), scene))["map"].is_null());
}

TEST_CASE("What is missing or not finite is left out, whatever it is") {
  const core::Scene scene = demo_scene();
  core::Diagnosis diagnosis = inclusion_sample(scene);
  SECTION("everything") {
    diagnosis = {};
    diagnosis.verdict = core::Verdict::unexplained;
    CHECK_THAT(diagnosis_page(diagnosis, scene), Contains("nothing that this program knows explains it"));
  }
  SECTION("courses without frames, or with fewer values than frames") {
    diagnosis.courses[0] = {};
    diagnosis.courses[1].assumed_mm.resize(3);
    diagnosis.courses[1].load.clear();
    diagnosis.courses[1].force_explained_N.clear();
    diagnosis.courses[2].time.resize(1);
  }
  SECTION("curves without a number") {
    for (core::TrialCourse& course : diagnosis.courses) {
      course.assumed_mm.assign(course.time.size(), NAN);
      course.load = course.force_seen_N = course.force_assumed_N = course.assumed_mm;
    }
  }
  SECTION("misfits, noise, probabilities and places") {
    const core::Misfit none{NAN, NAN, NAN};
    diagnosis.trials = diagnosis.held_out = {none, none, none};
    diagnosis.noise_marker_mm = diagnosis.noise_force_N = diagnosis.discretisation_marker_mm = diagnosis.seconds = NAN;
    diagnosis.alternatives[0].probability = diagnosis.alternatives[1].probability = NAN;
    diagnosis.findings[0].where = core::Finding::Place{core::Vec3(NAN, 0, 0), NAN};
  }
  SECTION("markers") {
    for (core::MarkerMisfit& marker : diagnosis.markers) marker.seen.x() = NAN;
    diagnosis.markers[1].rest.y() = INFINITY;
    const json data = viewer_data(diagnosis_page(diagnosis, scene));
    CHECK(data["trials"][0]["markers"][0]["seen"].is_null());
    CHECK(data["trials"][0]["markers"].size() == scene.markers.size() - 1);
  }
  SECTION("a map of another mesh") { diagnosis.mismatch_map.resize(7); }
  const std::string page = diagnosis_page(diagnosis, scene);
  CHECK(is_well_formed(page));
  for (const char* bad : {">nan", "nan,", "nan ", "\"nan", "nan%", ">inf", "inf,", "\"inf"}) {
    INFO(bad);
    CHECK(page.find(bad) == std::string::npos);
  }
}

TEST_CASE("A cut through the body shows the place where the plane meets it") {
  const core::Scene scene = demo_scene();
  core::Diagnosis diagnosis = inclusion_sample(scene);
  const auto mismatch = mismatch_at_nodes(scene.mesh, diagnosis.mismatch_map);
  const std::string through = body_slices(diagnosis, scene, mismatch, diagnosis.findings[0].where->center);
  CHECK(count(through, "<svg") == 3);
  CHECK(count(through, "class=\"place\"") == 3);
  CHECK(count(through, "class=\"rind base\"") == 2);  // not in the cut that is parallel to it
  CHECK_THAT(through, Contains("cut at z = 30 mm") && Contains("cut at y = 6 mm") && Contains("cut at x = 24 mm"));
  const std::string beyond = body_slices(diagnosis, scene, mismatch, core::Vec3(500, 500, 500));
  CHECK(count(beyond, "class=\"place\"") == 0);
  CHECK(count(beyond, "class=\"rind") == 0);
}
