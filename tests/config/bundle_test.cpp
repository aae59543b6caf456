#include "config/bundle.hpp"

#include <algorithm>
#include <chrono>

#include "tests/config/bundle_folder.hpp"

using namespace tissued::config;
using tissued::core::Mat3;
using tissued::core::Vec3;

namespace {

// What load_bundle says of the full bundle with one value changed, without the file's name.
std::string refusal_with(const std::string& key, const std::string& value) {
  const BundleFolder folder(with(kFullBundle, key, value));
  const std::string line = refusal([&] { load_bundle(folder.path()); });
  const std::string file = (folder.path() / "bundle.json").string() + ": ";
  REQUIRE(line.rfind(file, 0) == 0);
  REQUIRE(line.find('\n') == std::string::npos);
  return line.substr(file.size());
}

template <typename List>
std::vector<std::string> names_of(const List& list) {
  std::vector<std::string> names;
  for (const auto& item : list) names.push_back(item.name);
  return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("Every key of a bundle arrives in its struct") {
  const BundleFolder folder;
  const Bundle bundle = load_bundle(folder.path());
  CHECK(bundle.folder == folder.path());
  CHECK(bundle.mesh_file == folder.path() / "block.msh");
  CHECK(bundle.scene.name == "block");
  CHECK(bundle.scene.mesh.node_count() == 0);
  CHECK(bundle.scene.material.youngs_modulus == 6.5);
  CHECK(bundle.scene.material.poissons_ratio == 0.45);
  CHECK(bundle.scene.material.density == 1.02);
  CHECK(bundle.scene.fixed_surface == "base");
  CHECK(bundle.scene.skin_surface == "skin");
  CHECK(bundle.scene.gravity == Vec3(0, 0, -1));
  CHECK(bundle.scene.rate == 50.0);
  CHECK(bundle.scene.marker_noise == 0.1);
  CHECK(bundle.noise.marker == 0.1);
  CHECK(bundle.noise.target == 0.3);
  CHECK(bundle.noise.force == 0.01);
  CHECK(bundle.subject == "phantom");
  CHECK(bundle.dynamic);
  REQUIRE(names_of(bundle.marker_sets) == Names{"few"});
  CHECK(bundle.find_marker_set("few")->markers == Names{"M1", "M10"});
  CHECK(bundle.find_marker_set("many") == nullptr);
}

TEST_CASE("Pads, markers and targets keep the file's order") {
  const BundleFolder folder;
  const Bundle bundle = load_bundle(folder.path());
  CHECK(names_of(bundle.scene.pads) == Names{"A2", "A1"});
  CHECK(names_of(bundle.scene.markers) == Names{"M10", "M2", "M1"});
  CHECK(names_of(bundle.scene.targets) == Names{"T10", "T9"});
  CHECK(bundle.scene.markers[1].rest == Vec3(2, 0, 0));
  CHECK(bundle.scene.targets[0].rest == Vec3(0, 1, 0));
  const auto& pad = bundle.scene.pads[1];
  CHECK(pad.surface == "A1");
  CHECK(pad.center == Vec3(4, 5, 6));
  CHECK(pad.direction == Vec3(0, -1, 0));
  REQUIRE(bundle.pad_shapes.size() == 2);
  CHECK(bundle.pad_shapes[1].normal == Vec3(0, 1, 0));
  CHECK(bundle.pad_shapes[1].radius == 12.0);
}

TEST_CASE("Probes come with their shape and, where it is known, their image") {
  const BundleFolder folder;
  const Bundle bundle = load_bundle(folder.path());
  REQUIRE(names_of(bundle.scene.probes) == Names{"US", "bare"});
  const auto& probe = bundle.scene.probes[0];
  CHECK(probe.shape.center == Vec3(0, 1, -30));
  CHECK(probe.shape.half_extents == Vec3(20, 8, 30));
  CHECK(probe.shape.rounding == 3.0);
  CHECK(probe.friction == 0.1);
  CHECK(bundle.scene.probes[1].shape.center == Vec3::Zero());
  CHECK(bundle.scene.probes[1].shape.rounding == 0.0);
  CHECK(bundle.scene.probes[1].friction == 0.0);
  REQUIRE(bundle.probe_images.size() == 2);
  CHECK_FALSE(bundle.probe_images[1].has_value());
  REQUIRE(bundle.probe_images[0].has_value());
  const auto& image = *bundle.probe_images[0];
  CHECK((image.probe_T_image(Vec3(1, 2, 3)) - Vec3(-18, -2.5, 4)).norm() < 1e-12);
  CHECK(image.spacing == Eigen::Vector2d(0.1, 0.125));
  CHECK(image.size == Eigen::Vector2i(380, 512));
}

TEST_CASE("Trials come with their files and details, held-out ones last") {
  const BundleFolder folder;
  const Bundle bundle = load_bundle(folder.path());
  REQUIRE(names_of(bundle.trials) == Names{"push", "fall", "last"});
  CHECK(bundle.trials[0].file == folder.path() / "push.csv");
  CHECK_FALSE(bundle.trials[0].held_out);
  CHECK_FALSE(bundle.trials[0].end_frame.has_value());
  CHECK(bundle.trials[2].held_out);
  const TrialInfo& fall = *bundle.find_trial("fall");
  CHECK(fall.file == folder.path() / "fall.c3d");
  CHECK(fall.held_until_frame == 66);
  CHECK(fall.end_frame == 500);
  CHECK(fall.start == "straight");
  REQUIRE(fall.loads.size() == 1);
  CHECK(fall.loads[0].edge[1] == Vec3(0, 30, 30));
  CHECK(fall.loads[0].force == Vec3(0, 0, -0.5));
  CHECK(fall.loads[0].mass == 52.0);
  CHECK(bundle.find_trial("none") == nullptr);
}

TEST_CASE("world_from_tracker takes tracker to tissue coordinates") {
  const BundleFolder folder;
  const Bundle bundle = load_bundle(folder.path());
  CHECK(bundle.has_tracker_pose);
  CHECK((bundle.tissue_from_tracker(Vec3(1, 0, 0)) - Vec3(10, 21, 30)).norm() < 1e-12);

  const BundleFolder without(with(kFullBundle, "/world_from_tracker", ""));
  const Bundle plain = load_bundle(without.path());
  CHECK_FALSE(plain.has_tracker_pose);
  CHECK(plain.tissue_from_tracker.rotation == Mat3::Identity());
}

TEST_CASE("What a bundle leaves out has a plain meaning") {
  std::string text = kFullBundle;
  for (const char* key :
       {"/gravity", "/subject", "/dynamic", "/world_from_tracker", "/actuators", "/probes", "/marker_sets",
        "/marker_note", "/noise/target", "/noise/force", "/trials", "/held_out", "/trial", "/name"}) {
    text = with(text, key, "");
  }
  const BundleFolder folder(text);
  const Bundle bundle = load_bundle(folder.path());
  CHECK(bundle.scene.name == folder.path().filename().string());
  CHECK(load_bundle(folder.path() / "").scene.name == bundle.scene.name);
  CHECK(bundle.scene.gravity == Vec3::Zero());
  CHECK(bundle.subject.empty());
  CHECK_FALSE(bundle.dynamic);
  CHECK(bundle.scene.pads.empty());
  CHECK(bundle.trials.empty());
  CHECK(bundle.noise.target == 0.0);
}

TEST_CASE("Directions and rotations a little off are put right") {
  const BundleFolder folder(with(with(kFullBundle, "/actuators/A1/direction", "[0, -0.9995, 0]"),
                                 "/world_from_tracker/rotation", "[[0, -1.0, 0.0001], [0.9999, 0, 0], [0, 0, 1]]"));
  const Bundle bundle = load_bundle(folder.path());
  CHECK(bundle.scene.pads[1].direction == Vec3(0, -1, 0));
  const Mat3& rotation = bundle.tissue_from_tracker.rotation;
  CHECK((rotation * rotation.transpose() - Mat3::Identity()).norm() < 1e-14);
}

TEST_CASE("Every bad value of a bundle is refused with key, value and limit") {
  struct Case {
    const char* key;
    const char* value;
    const char* line;
  };
  const Case cases[] = {
      {"/format", R"("tissue-recording/2")", R"(/format: "tissue-recording/2" is not "tissue-recording/1")"},
      {"/format", "", "/format: is missing"},
      {"/name", "3", "/name: 3 is not a string"},
      {"/name", R"("")", R"(/name: "" has 0 characters, fewer than the minimum 1)"},
      {"/units", "", "/units: is missing"},
      {"/units/length", R"("cm")", R"(/units/length: "cm" is not "mm")"},
      {"/units/time", R"("ms")", R"(/units/time: "ms" is not "s")"},
      {"/units/stress", R"("Pa")", R"(/units/stress: "Pa" is not "kPa")"},
      {"/units/force", "", "/units/force: is missing"},
      {"/units/density", R"("kg/m3")", R"(/units/density: "kg/m3" is not "g/cm3")"},
      {"/units/gravity", R"("m/s2")", R"(/units/gravity: "m/s2" is not "g0")"},
      {"/units/mass", R"("kg")",
       "/units/mass: unknown key; known are length, time, stress, force, density and gravity"},
      {"/mesh", R"("")", R"(/mesh: "" has 0 characters, fewer than the minimum 1)"},
      {"/mesh", R"("../block.msh")", R"(/mesh: "../block.msh" leaves the bundle's folder)"},
      {"/mesh", R"("/etc/passwd")", R"(/mesh: "/etc/passwd" leaves the bundle's folder)"},
      {"/fixed", "null", "/fixed: null is not a string"},
      {"/surface", R"("0123456789012345678901234")",
       R"(/surface: "0123456789012345678901234" has 25 characters, more than the maximum 24)"},
      {"/material/model", R"("linear")", R"(/material/model: "linear" is not "neo-hookean")"},
      {"/material/youngs_modulus", "0", "/material/youngs_modulus: 0 is not above 0"},
      {"/material/youngs_modulus", "2e6", "/material/youngs_modulus: 2000000.0 is above the maximum 1000000"},
      {"/material/poissons_ratio", "0.5", "/material/poissons_ratio: 0.5 is not below 0.5"},
      {"/material/poissons_ratio", "-1", "/material/poissons_ratio: -1 is not above -1"},
      {"/material/density", "-0.1", "/material/density: -0.1 is not above 0"},
      {"/material/damping", "1",
       "/material/damping: unknown key; known are model, youngs_modulus, poissons_ratio and density"},
      {"/gravity", "[0, -1]", "/gravity: [0,-1] has 2 items, fewer than the minimum 3"},
      {"/gravity/2", "-981", "/gravity/2: -981 is below the minimum -100"},
      {"/subject", R"("a\tb")", R"(/subject: "a\tb" does not match ^[ -~]*$)"},
      {"/rate", "0", "/rate: 0 is below the minimum 1"},
      {"/rate", "1e4", "/rate: 10000.0 is above the maximum 2000"},
      {"/dynamic", "1", "/dynamic: 1 is not a boolean"},
      {"/world_from_tracker/rotation", "", "/world_from_tracker/rotation: is missing"},
      {"/world_from_tracker/rotation/1/1", "0.1",
       "/world_from_tracker/rotation: [[0,-1,0],[1,0.1,0],[0,0,1]] is not a rotation: its rows are off orthonormal by "
       "0.1, more than 0.001"},
      {"/world_from_tracker/rotation/2/2", "-1",
       "/world_from_tracker/rotation: [[0,-1,0],[1,0,0],[0,0,-1]] is not a rotation but a reflection: its determinant "
       "is -1, not 1"},
      {"/world_from_tracker/translation/0", "20000",
       "/world_from_tracker/translation/0: 20000 is above the maximum 10000"},
      {"/actuators/A1/surface", R"("base")",
       R"(/actuators/A1/surface: "base" is the surface that is held still (/fixed))"},
      {"/actuators/A1/center", "", "/actuators/A1/center: is missing"},
      {"/actuators/A1/direction", "[0, 1, 0.1]",
       "/actuators/A1/direction: [0,1,0.1] is not a unit vector: its length is 1.00499, not 1"},
      {"/actuators/A1/normal", "[0, 0, 0]",
       "/actuators/A1/normal: [0,0,0] is not a unit vector: its length is 0, not 1"},
      {"/actuators/A1/radius", "0", "/actuators/A1/radius: 0 is not above 0"},
      {"/actuators/A1/attachment", R"("sliding")", R"(/actuators/A1/attachment: "sliding" is not "glued")"},
      {"/actuators/a~1b", "{}", "/actuators/a~1b/surface: is missing"},
      {"/probes/US/shape", "", "/probes/US/shape: is missing"},
      {"/probes/US/shape/half_extents/1", "0.1", "/probes/US/shape/half_extents/1: 0.1 is below the minimum 0.5"},
      {"/probes/US/shape/rounding", "8.5", "/probes/US/shape/rounding: 8.5 is above the smallest half extent 8.0"},
      {"/probes/US/shape/rounding", "-1", "/probes/US/shape/rounding: -1 is below the minimum 0"},
      {"/probes/US/friction", "2.5", "/probes/US/friction: 2.5 is above the maximum 2"},
      {"/probes/US/image/spacing/0", "0", "/probes/US/image/spacing/0: 0 is not above 0"},
      {"/probes/US/image/spacing", "[0.1]", "/probes/US/image/spacing: [0.1] has 1 item, fewer than the minimum 2"},
      {"/probes/US/image/size/1", "0", "/probes/US/image/size/1: 0 is below the minimum 1"},
      {"/probes/US/image/size/0", "20000", "/probes/US/image/size/0: 20000 is above the maximum 16384"},
      {"/probes/US/image/probe_T_image/rotation", "[[1, 0, 0], [0, 1, 0], [0, 0, -1]]",
       "/probes/US/image/probe_T_image/rotation: [[1,0,0],[0,1,0],[0,0,-1]] is not a rotation but a reflection: its "
       "determinant is -1, not 1"},
      {"/probes/US/image/probe_T_image/translation", "", "/probes/US/image/probe_T_image/translation: is missing"},
      {"/probes/A1", R"({"shape": {"half_extents": [5, 5, 5]}})",
       "/probes/A1: the name is given twice, here and in /actuators"},
      {"/markers/US", "[0, 0, 0]", "/markers/US: the name is given twice, here and in /probes"},
      {"/targets/US", "[0, 0, 0]", "/targets/US: the name is given twice, here and in /probes"},
      {"/markers/M1", "[1, 2, \"3\"]", "/markers/M1/2: \"3\" is not a number"},
      {"/markers/M1/0", "1e5", "/markers/M1/0: 100000.0 is above the maximum 10000"},
      {"/markers/", "[0, 0, 0]", R"(/markers/: "" has 0 characters, fewer than the minimum 1)"},
      {"/markers/A1", "[0, 0, 0]", "/markers/A1: the name is given twice, here and in /actuators"},
      {"/targets/M2", "[0, 0, 0]", "/targets/M2: the name is given twice, here and in /markers"},
      {"/targets/A2", "[0, 0, 0]", "/targets/A2: the name is given twice, here and in /actuators"},
      {"/marker_sets/few/0", R"("M3")", R"(/marker_sets/few/0: "M3" is not one of /markers)"},
      {"/marker_sets/few/1", R"("M1")", R"(/marker_sets/few/1: "M1" is given twice)"},
      {"/marker_sets/few", "[]", "/marker_sets/few: [] has 0 items, fewer than the minimum 1"},
      {"/marker_sets/all", R"(["M1"])", R"(/marker_sets/all: "all" always means every marker and cannot name a set)"},
      {"/noise/marker", "0", "/noise/marker: 0 is not above 0"},
      {"/noise/target", "-1", "/noise/target: -1 is below the minimum 0"},
      {"/noise/force", "[]", "/noise/force: [] is not a number"},
      {"/trials/0", R"("../push")", R"(/trials/0: "../push" does not match ^[A-Za-z0-9_][A-Za-z0-9_ .+-]*$)"},
      {"/trials/1", R"("push")", R"(/trials/1: "push" is given twice)"},
      {"/held_out/0", R"("push")", R"(/held_out/0: "push" is in /trials, too: what is fitted is not held out)"},
      {"/trial/other", "{}", "/trial/other: names no trial of /trials or /held_out"},
      {"/trial/fall/file", R"("../fall.c3d")", R"(/trial/fall/file: "../fall.c3d" leaves the bundle's folder)"},
      {"/trial/fall/held_until_frame", "-1", "/trial/fall/held_until_frame: -1 is below the minimum 0"},
      {"/trial/fall/end_frame", "66", "/trial/fall/end_frame: 66 is not above held_until_frame 66"},
      {"/trial/fall/end_frame", "70.5", "/trial/fall/end_frame: 70.5 is not an integer or null"},
      {"/trial/fall/loads/0/edge", "[[0,0,30]]",
       "/trial/fall/loads/0/edge: [[0,0,30]] has 1 item, fewer than the minimum 2"},
      {"/trial/fall/loads/0/force", "", "/trial/fall/loads/0/force: is missing"},
      {"/trial/fall/loads/0/mass", "-52", "/trial/fall/loads/0/mass: -52 is below the minimum 0"},
  };
  for (const Case& bad : cases) {
    CAPTURE(bad.key, bad.value);
    CHECK(refusal_with(bad.key, bad.value) == bad.line);
  }
}

TEST_CASE("A bundle asks for no more markers, pads and targets than a tracker frame holds") {
  const auto points = [](std::size_t count) {
    Json named = Json::object();
    for (std::size_t i = 0; i < count; ++i) named[std::to_string(i)] = {0, 0, 0};
    return named.dump();
  };
  const std::string many = with(with(kFullBundle, "/marker_sets", ""), "/markers", points(128));
  CHECK(load_bundle(BundleFolder(many).path()).scene.markers.size() == 128);
  CHECK(refusal_with("/markers", points(129)).find("has 129 keys, more than the maximum 128") != std::string::npos);
  CHECK(refusal_with("/targets", points(65)).find("has 65 keys, more than the maximum 64") != std::string::npos);
  CHECK(refusal_with("/actuators", points(33)).find("has 33 keys, more than the maximum 32") != std::string::npos);
}

TEST_CASE("A bundle as large as a file may be is refused in a moment") {
  Json names = Json::array();
  for (int i = 0; i < 100000; ++i) names.push_back(std::to_string(i));  // distinct: all pairs would be compared
  const auto start = std::chrono::steady_clock::now();
  for (const char* key : {"/marker_sets/few", "/trials", "/held_out"}) {
    CHECK(refusal_with(key, names.dump()).find("has 100000 items, more than the maximum") != std::string::npos);
  }
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(60));  // minutes each, if it were
}

TEST_CASE("A bundle without its files says which") {
  const BundleFolder folder;
  std::filesystem::remove(folder.path() / "block.msh");
  CHECK(refusal([&] { load_bundle(folder.path()); }) ==
        (folder.path() / "bundle.json").string() + ": /mesh: \"block.msh\" is not a file in " + folder.path().string());
  std::filesystem::remove(folder.path() / "bundle.json");
  CHECK(refusal([&] { load_bundle(folder.path()); }) == (folder.path() / "bundle.json").string() + ": no such file");
  CHECK(refusal([&] { load_bundle(folder.path() / "none"); }) ==
        (folder.path() / "none" / "bundle.json").string() + ": no such file");
}

TEST_CASE("Overrides pass the checks of the file") {
  const BundleFolder folder;
  const auto load_with = [&](std::vector<std::string> overrides) { return load_bundle(folder.path(), overrides); };
  const auto refused = [&](const std::string& override) { return refusal([&] { load_with({override}); }); };

  const Bundle bundle = load_with({"material.poissons_ratio=0.42", "gravity=[0, 1, 0]", "name=other",
                                   "material.poissons_ratio=0.43", "trial.push.start=bent"});
  CHECK(bundle.scene.material.poissons_ratio == 0.43);
  CHECK(bundle.scene.material.youngs_modulus == 6.5);
  CHECK(bundle.scene.gravity == Vec3(0, 1, 0));
  CHECK(bundle.scene.name == "other");
  CHECK(bundle.find_trial("push")->start == "bent");

  CHECK(refused("material.poissons_ratio=0.5") ==
        "--set material.poissons_ratio=0.5: /material/poissons_ratio: 0.5 is not below 0.5");
  CHECK(
      refused("material.poisson=0.4") ==
      "--set material.poisson=0.4: /material/poisson: unknown key; known are model, youngs_modulus, poissons_ratio and "
      "density");
  CHECK(refused("gravity=[0, 0") == "--set gravity=[0, 0: /gravity: \"[0, 0\" is not an array");
  CHECK(refused("gravity.2=-1") == "--set gravity.2=-1: /gravity: is not an object");
  CHECK(refused("actuators.A1.direction=[1, 1, 1]") ==
        "--set actuators.A1.direction=[1, 1, 1]: /actuators/A1/direction: [1,1,1] is not a unit vector: its length is "
        "1.73205, not 1");
  CHECK(refused("actuators.A1={}") == "--set actuators.A1={}: /actuators/A1/surface: is missing");
  CHECK(refused("material.density=") == "--set material.density=: /material/density: \"\" is not a number");
  CHECK(refused("material") == "--set material: needs KEY=VALUE");
  CHECK(refused("a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a=1") ==
        "--set a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a.a=1: nested deeper than 16 levels");
  CHECK(refused("=3") == "--set =3: needs KEY=VALUE");
  CHECK(refused("name=a\n") == "--set name=a?: /name: \"a\\n\" does not match ^[ -~]+$");
  CHECK(refused("a..b=1") ==
        "--set a..b=1: /a: unknown key; known are format, name, units, mesh, fixed, surface, "
        "material, gravity, subject, rate, dynamic, world_from_tracker, actuators, probes, markers, marker_sets, "
        "marker_note, "
        "targets, noise, trials, held_out and trial");
}

TEST_CASE("An override is not blamed for what the file says") {
  const BundleFolder folder(with(kFullBundle, "/rate", "0"));
  const std::vector<std::string> overrides{"gravity=[0,0,0]"};
  CHECK(refusal([&] { load_bundle(folder.path(), overrides); }) ==
        (folder.path() / "bundle.json").string() + ": /rate: 0 is below the minimum 1");
}

TEST_CASE("Every corrupted byte of a bundle is read or refused in one line") {
  const std::string text = kFullBundle;
  int refused = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string corrupted = text;
    corrupted[i] = static_cast<char>(corrupted[i] ^ (1 << (i % 8)));
    const BundleFolder folder(corrupted);
    try {
      load_bundle(folder.path());
    } catch (const ConfigError& error) {
      ++refused;
      const std::string line = error.what();
      CAPTURE(i, line);
      REQUIRE(line.rfind(folder.path().string(), 0) == 0);
      REQUIRE(line.find('\n') == std::string::npos);
    }
  }
  CHECK(refused > static_cast<int>(text.size()) / 2);
}

TEST_CASE("The demo phantom loads") {
  const Bundle demo = load_bundle(std::filesystem::path(TISSUED_SOURCE_DIR) / "config/demo");
  CHECK(names_of(demo.scene.pads) == Names{"A1", "A2", "A3", "A4"});
  CHECK(demo.scene.markers.size() == 15);
  CHECK(demo.scene.targets.size() == 3);
}

TEST_CASE("The shared recordings load") {
  const std::filesystem::path shared = TISSUED_SHARED_DATA;
  if (!std::filesystem::exists(shared / "recordings")) {
    WARN("no shared recordings at " << shared << ": skipped");
    return;
  }
  int bundles = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(shared)) {
    if (entry.path().filename() != "bundle.json") continue;
    CAPTURE(entry.path());
    ++bundles;
    const Bundle bundle = load_bundle(entry.path().parent_path());
    for (const TrialInfo& trial : bundle.trials) CHECK(std::filesystem::exists(trial.file));
  }
  CHECK(bundles >= 14);
  CHECK(load_bundle(shared / "recordings/open/open-two").find_trial("held-a12-10")->held_out);

  const Bundle table1 = load_bundle(shared / "recordings/paper/table1");
  CHECK(table1.scene.markers.size() == 19);
  CHECK(table1.scene.pads.size() == 4);
  CHECK(table1.trials.size() == 16);
  CHECK(table1.find_marker_set("set2")->markers.size() == 10);

  const Bundle cirs = load_bundle(shared / "recordings/paper/cirs");
  CHECK(cirs.scene.targets[9].name == "T10");

  const Bundle beam = load_bundle(shared / "real/beam");
  CHECK(beam.dynamic);
  CHECK(beam.find_trial("load52")->file == shared / "real/beam/load52.c3d");
  CHECK(beam.find_trial("load52")->loads.at(0).force.z() == -0.51012);
  CHECK((beam.tissue_from_tracker(Vec3(1, 2, 3)) - Vec3(3, -2, 1)).norm() < 1e-12);
}
