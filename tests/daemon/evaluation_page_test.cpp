#include "daemon/evaluation_page.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "daemon/afshar_paper.hpp"
#include "tests/daemon/evaluation_bundle.hpp"

using namespace tissued;
using namespace tissued::daemon;

TEST_CASE("The page is well-formed, loads nothing, runs nothing, and says what it is not") {
  const TemporaryFolder folder;
  const std::string name = GENERATE("cube", "table1", "gel", "cirs");  // also under the names of the papers' bundles
  EvaluationRequest request;
  request.bundles = {write_evaluation_bundle(folder, name).string()};
  request.models = {named_model("admm"), named_model("paper"), parse_variant("a<b>&c:material.youngs_modulus=5"),
                    named_model("rigid"), named_model("pbd")};
  Evaluation evaluation(request);
  evaluation.run(2, [](std::size_t) {});
  const std::string page = evaluation_page(evaluation, 2);

  CHECK_THAT(page, Catch::Contains("not a medical device") && Catch::Contains("prefers-color-scheme: dark") &&
                       Catch::Contains("@media print") && Catch::Contains("a&lt;b&gt;&amp;c"));
  for (const char* loads : {"http:", "https:", "src=", "href=", "url(", "@import", "<script", "<link", "nan", "inf,"}) {
    INFO(loads);
    CHECK(page.find(loads) == std::string::npos);
  }
  CHECK((page.find("Beside the first paper") != std::string::npos) == (name == "table1"));
  CHECK((page.find("Beside the second paper") != std::string::npos) == (name == "gel" || name == "cirs"));
  const auto file = folder.write("index.html", page);
  const std::string command = std::string(TISSUED_PYTHON) +
                              " -c 'import sys, xml.etree.ElementTree as E; E.parse(sys.argv[1])' " + file.string();
  CHECK(std::system(command.c_str()) == 0);
}

TEST_CASE("The recordings make the pushes of the paper's Table I") {
  const std::filesystem::path folder = std::filesystem::path(TISSUED_SHARED_DATA) / "recordings/paper/table1";
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: no recordings in " << folder);
    return;
  }
  const config::Bundle bundle = config::load_bundle(folder);
  REQUIRE(bundle.scene.name == afshar::kBundleName);
  REQUIRE(bundle.trials.size() == afshar::kExperiments.size());
  for (std::size_t i = 0; i < bundle.trials.size(); ++i) {
    const Recording recording(bundle, bundle.trials[i], read_trial(bundle.trials[i].file));
    std::string actuators;
    for (const PadPush& push : recording.pushes()) {
      actuators += (actuators.empty() ? "" : " and ") + bundle.scene.pads[push.pad].name.substr(1);
      CHECK(push.largest_mm == Approx(afshar::kExperiments[i].movement_mm).margin(0.01));
    }
    CHECK(actuators == afshar::kExperiments[i].actuators);
    CHECK(afshar::kExperiments[i].number == static_cast<int>(i) + 1);
  }
  CHECK(bundle.find_marker_set("set1")->markers.size() == afshar::kMarkers);
  CHECK(bundle.find_marker_set("set2")->markers.size() == afshar::kFewMarkers);
}
