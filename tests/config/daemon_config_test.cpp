#include "config/daemon_config.hpp"

#include <set>

#include "config/schema.hpp"
#include "tests/config/bundle_folder.hpp"

using namespace tissued::config;
using namespace std::chrono_literals;
using tissued::core::FemElement;
using tissued::core::NoisePreset;
using tissued::core::Scheme;
using tissued::core::TimeScheme;
using tissued::core::Vec3;

namespace {

const char* const kFullConfig = R"({
  "format": "tissued-config/1", "bundle": ".",
  "tracker": {"address": "0.0.0.0", "port": 5000, "frame_deadline_ms": 12.5, "subject": "other",
              "peer": "192.168.7.1", "peer_port": 801},
  "clients": {"address": "::1", "port": 0, "max_subscribers": 3, "lease_s": 25, "max_requests_per_s": 30,
              "prove_addresses": true},
  "insecure": true,
  "simulator": {"kind": "admm", "scheme": "algorithm-1", "iterations": 20, "tolerance": 0.01, "weight_scale": 2,
                "threads": 1, "time_step": 0.005,
                "pbd": {"particle_spacing": 4, "cluster_spacing": 9.6, "cluster_radius": 9, "cluster_stiffness": 0.4,
                        "time_step": 0.01, "substeps": 2, "iterations": 7, "damping": 10, "collision_distance": 2,
                        "shape_friction": 0.3, "particle_friction": 0.2, "self_collision": false,
                        "readout": "nearest"},
                "rigid": {"follow": "markers"}},
  "material": {"youngs_modulus": 7, "poissons_ratio": 0.4, "density": 1.1}, "gravity": [1, 0, 0],
  "filter": {"preset": "paper", "process_noise": 4, "measurement_noise": 0.2, "modes": 100},
  "fem": {"element": "p1", "dynamics": "generalized-alpha", "spectral_radius": 0.5, "mass_damping": 2, "stiffness_damping": 0.1},
  "markers": ["M1", "M2"],
  "registration": {"fit": false, "rest_frames": 10, "placement_sd": 1, "rest_tolerance": 0.3},
  "staleness": {"stale_after_ms": 50, "lost_after_ms": 500},
  "log": {"level": "debug", "file": "live.log", "max_mb": 0.25, "files": 3},
  "realtime": {"enabled": true, "simulation_cpu": 1, "io_cpu": 0}
})";

std::vector<std::string> marker_names(const DaemonConfig& config) {
  std::vector<std::string> names;
  for (const auto& marker : config.bundle.scene.markers) names.push_back(marker.name);
  return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("Every key of a configuration arrives in its struct") {
  const BundleFolder folder;
  const DaemonConfig config = load_daemon_config(folder.write("full.json", kFullConfig));
  CHECK(config.source == (folder.path() / "full.json").string());
  CHECK(config.tracker.address == "0.0.0.0");
  CHECK(config.tracker.port == 5000);
  CHECK(config.tracker.frame_deadline == 12500us);
  CHECK(config.tracker.subject == "other");
  CHECK(config.clients.address == "::1");
  CHECK(config.clients.port == 0);
  CHECK(config.clients.max_subscribers == 3);
  CHECK(config.tracker.peer == "192.168.7.1");
  CHECK(config.tracker.peer_port == 801);
  CHECK(config.clients.lease == 25s);
  CHECK(config.clients.max_requests_per_s == 30);
  CHECK(config.clients.prove_addresses);
  CHECK(config.keys.empty());
  CHECK(config.simulator.kind == "admm");
  CHECK(config.simulator.solver.scheme == Scheme::algorithm_1);
  CHECK(config.simulator.solver.iterations == 20);
  CHECK(config.simulator.solver.tolerance == 0.01);
  CHECK(config.simulator.solver.weight_scale == 2.0);
  CHECK(config.simulator.solver.threads == 1);
  CHECK(config.simulator.solver.time_step == 0.005);
  const tissued::core::PbdOptions& pbd = config.simulator.pbd;
  CHECK(pbd.particle_spacing == 4.0);
  CHECK(pbd.cluster_spacing == 9.6);
  CHECK(pbd.cluster_radius == 9.0);
  CHECK(pbd.cluster_stiffness == 0.4);
  CHECK(pbd.time_step == 0.01);
  CHECK(pbd.substeps == 2);
  CHECK(pbd.iterations == 7);
  CHECK(pbd.damping == 10.0);
  CHECK(pbd.collision_distance == 2.0);
  CHECK(pbd.shape_friction == 0.3);
  CHECK(pbd.particle_friction == 0.2);
  CHECK_FALSE(pbd.self_collision);
  CHECK(pbd.readout == tissued::core::PbdReadout::nearest);
  CHECK(config.simulator.rigid.follow == tissued::core::RigidOptions::Follow::markers);
  CHECK(config.bundle.scene.material.youngs_modulus == 7.0);
  CHECK(config.bundle.scene.material.poissons_ratio == 0.4);
  CHECK(config.bundle.scene.material.density == 1.1);
  CHECK(config.bundle.scene.gravity == Vec3(1, 0, 0));
  CHECK(config.simulator.filter.preset == NoisePreset::paper);
  CHECK(config.simulator.filter.process_noise == 4.0);
  CHECK(config.simulator.filter.measurement_noise == 0.2);
  CHECK(config.simulator.filter.modes == 100);
  CHECK(config.simulator.fem.element == FemElement::p1);
  REQUIRE(config.simulator.fem.dynamics);
  CHECK(config.simulator.fem.dynamics->kind == TimeScheme::Kind::generalized_alpha);
  CHECK(config.simulator.fem.dynamics->spectral_radius == 0.5);
  CHECK(config.simulator.fem.damping.mass == 2.0);
  CHECK(config.simulator.fem.damping.stiffness == 0.1);
  CHECK_FALSE(config.registration.fit);
  CHECK(config.registration.rest_frames == 10);
  CHECK(config.registration.placement_sd == 1.0);
  CHECK(config.registration.rest_tolerance == 0.3);
  CHECK(config.staleness.stale_after == 50ms);
  CHECK(config.staleness.lost_after == 500ms);
  CHECK(config.log.level == LogLevel::debug);
  CHECK(config.log.file == folder.path() / "live.log");
  CHECK(config.log.max_bytes == 250000);
  CHECK(config.log.files == 3);
  CHECK(config.realtime.enabled);
  CHECK(config.realtime.simulation_cpu == 1);
  CHECK(config.realtime.io_cpu == 0);
}

TEST_CASE("A bundle alone is enough to start from") {
  const BundleFolder folder;
  const DaemonConfig config = config_for_bundle(folder.path());
  CHECK(config.source == folder.path().string());
  CHECK(config.bundle.scene.name == "block");
  CHECK(config.tracker.port == 51001);
  CHECK(config.tracker.subject == "phantom");
  CHECK(config.tracker.frame_deadline == 4ms);
  CHECK(config.clients.port == 51010);
  CHECK(config.simulator.kind == "kf-admm");
  CHECK(config.simulator.solver.time_step == 0.02);
  CHECK(config.simulator.fem.element == FemElement::p2);
  CHECK_FALSE(config.simulator.fem.dynamics);
  CHECK(config.bundle.scene.material.youngs_modulus == 6.5);
  CHECK(config.bundle.scene.gravity == Vec3(0, 0, -1));
  CHECK(config.registration.fit);
  CHECK(marker_names(config) == Names{"M10", "M2", "M1"});
  CHECK(config.unused_markers.empty());
  CHECK(config.log.level == LogLevel::warn);
  CHECK(config.log.file.empty());
  CHECK_FALSE(config.realtime.enabled);
  CHECK_FALSE(config.realtime.simulation_cpu);

  const BundleFolder fixed(with(with(kFullBundle, "/world_from_tracker", ""), "/rate", "250"));
  CHECK_FALSE(config_for_bundle(fixed.path()).registration.fit);
  CHECK(config_for_bundle(fixed.path()).tracker.frame_deadline == 2ms);
}

TEST_CASE("Markers are chosen by all, by a set or one by one, in the bundle's order") {
  const BundleFolder folder;
  const auto choose = [&](const std::string& override) {
    const Names overrides{override};
    return config_for_bundle(folder.path(), overrides);
  };
  CHECK(marker_names(choose("markers=all")) == Names{"M10", "M2", "M1"});
  CHECK(marker_names(choose("markers=few")) == Names{"M10", "M1"});
  CHECK(choose("markers=few").unused_markers == Names{"M2"});
  CHECK(marker_names(choose(R"(markers=["M1", "M2"])")) == Names{"M2", "M1"});
  CHECK(marker_names(choose("markers=[]")).empty());
}

TEST_CASE("The bundle's folder is relative to the configuration") {
  const BundleFolder folder;
  std::filesystem::create_directory(folder.path() / "configs");
  const auto path = folder.write("configs/a.json", with(kFullConfig, "/bundle", "\"..\""));
  CHECK(load_daemon_config(path).bundle.scene.name == "block");
  const auto absolute =
      folder.write("configs/b.json", with(kFullConfig, "/bundle", Json(folder.path().string()).dump()));
  CHECK(load_daemon_config(absolute).bundle.scene.name == "block");
  const auto wrong = folder.write("configs/c.json", with(kFullConfig, "/bundle", "\"none\""));
  CHECK(refusal([&] { load_daemon_config(wrong); }) ==
        wrong.string() + ": /bundle: " + (folder.path() / "configs/none").string() + " holds no bundle.json");
}

TEST_CASE("What a configuration said is kept whole, and means the same wherever it is read") {
  const BundleFolder folder;
  const DaemonConfig config = load_daemon_config(
      folder.write("config.json", kFullConfig),
      std::vector<std::string>{"model=found/model.json", "record=live.rec", "simulator.iterations=33"});
  const DaemonConfig again = config_from_text(config.document, "somewhere else");
  CHECK(again.document == config.document);
  CHECK(again.simulator.solver.iterations == 33);
  CHECK(again.simulator.pbd.cluster_spacing == 9.6);
  CHECK(again.bundle.scene.markers.size() == 2);
  CHECK(again.model.is_absolute());
  CHECK(again.model.lexically_normal() == std::filesystem::absolute(config.model).lexically_normal());
  CHECK(again.bundle.folder.is_absolute());
  CHECK(again.record.empty());  // a run that is repeated does not write over its recording
  CHECK_THROWS_WITH(config_from_text("{", "somewhere else"), Catch::Contains("somewhere else"));
}

TEST_CASE("Every bad value of a configuration is refused with key, value and limit") {
  struct Case {
    const char* key;
    const char* value;
    const char* line;
  };
  const Case cases[] = {
      {"/format", R"("tissued-config/0")", R"(/format: "tissued-config/0" is not "tissued-config/1")"},
      {"/bundle", "", "/bundle: is missing"},
      {"/bundle", "7", "/bundle: 7 is not a string"},
      {"/simulators", "{}",
       "/simulators: unknown key; known are format, bundle, tracker, clients, keys, insecure, model, simulator, "
       "material, gravity, filter, fem, alarm, markers, registration, staleness, record, record_max_mb, metrics, log "
       "and realtime"},
      {"/model", "3", "/model: 3 is not a string"},
      {"/tracker", "51001", "/tracker: 51001 is not an object"},
      {"/tracker/address", R"("localhost")", R"(/tracker/address: "localhost" is not an IPv4 or IPv6 address)"},
      {"/tracker/address", R"("127.0.0.256")", R"(/tracker/address: "127.0.0.256" is not an IPv4 or IPv6 address)"},
      {"/tracker/port", "65536", "/tracker/port: 65536 is above the maximum 65535"},
      {"/tracker/port", "-1", "/tracker/port: -1 is below the minimum 0"},
      {"/tracker/port", "51001.0", "/tracker/port: 51001.0 is not an integer"},
      {"/tracker/port", R"("51001")", R"(/tracker/port: "51001" is not an integer)"},
      {"/tracker/frame_deadline_ms", "0", "/tracker/frame_deadline_ms: 0 is not above 0"},
      {"/tracker/frame_deadline_ms", "20",
       "/tracker/frame_deadline_ms: 20.0 is not below the frame period of the bundle, 20.0"},
      {"/tracker/subject", "3", "/tracker/subject: 3 is not a string or null"},
      {"/tracker/peer", R"("vicon")", R"(/tracker/peer: "vicon" is not an IPv4 or IPv6 address)"},
      {"/tracker/peer_port", "0", "/tracker/peer_port: 0 is below the minimum 1"},
      {"/insecure", "false",
       R"(/tracker/address: "0.0.0.0" can be reached by others than this machine: give a file of `keys`, or say )"
       "`insecure` (--insecure) and believe anybody"},
      {"/insecure", "1", "/insecure: 1 is not a boolean"},
      {"/keys", "1", "/keys: 1 is not a string"},
      {"/clients/max_requests_per_s", "0", "/clients/max_requests_per_s: 0 is below the minimum 1"},
      {"/clients/address", R"("")", R"(/clients/address: "" is not an IPv4 or IPv6 address)"},
      {"/clients/port", "1e9", "/clients/port: 1000000000.0 is not an integer"},
      {"/clients/max_subscribers", "0", "/clients/max_subscribers: 0 is below the minimum 1"},
      {"/clients/max_subscribers", "257", "/clients/max_subscribers: 257 is above the maximum 256"},
      {"/clients/lease_s", "0", "/clients/lease_s: 0 is below the minimum 1"},
      {"/simulator/kind", R"("sofa")",
       R"(/simulator/kind: "sofa" is not one of "kf-admm", "admm", "fem", "pbd" or "rigid")"},
      {"/simulator/pbd/cluster_stiffness", "1.1", "/simulator/pbd/cluster_stiffness: 1.1 is above the maximum 1"},
      {"/simulator/pbd/cluster_radius", "4",
       "/simulator/pbd/cluster_radius: 4.0 is below half of cluster_spacing, 4.8"},
      {"/simulator/pbd/damping", "300", "/simulator/pbd/damping: 300.0 is above one over a substep, 200.0"},
      {"/simulator/pbd/substeps", "0", "/simulator/pbd/substeps: 0 is below the minimum 1"},
      {"/simulator/rigid/follow", R"("pads")", R"(/simulator/rigid/follow: "pads" is not one of "none" or "markers")"},
      {"/fem/dynamics", R"("explicit")",
       R"(/fem/dynamics: "explicit" is not one of "quasi-static", "implicit-euler" or "generalized-alpha")"},
      {"/fem/spectral_radius", "1.5", "/fem/spectral_radius: 1.5 is above the maximum 1"},
      {"/simulator/scheme", R"("perframe")",
       R"(/simulator/scheme: "perframe" is not one of "per-frame" or "algorithm-1")"},
      {"/simulator/iterations", "0", "/simulator/iterations: 0 is below the minimum 1"},
      {"/simulator/iterations", "10001", "/simulator/iterations: 10001 is above the maximum 10000"},
      {"/simulator/tolerance", "-0.1", "/simulator/tolerance: -0.1 is below the minimum 0"},
      {"/simulator/weight_scale", "0", "/simulator/weight_scale: 0 is below the minimum 0.001"},
      {"/simulator/threads", "65", "/simulator/threads: 65 is above the maximum 64"},
      {"/simulator/time_step", "0", "/simulator/time_step: 0 is below the minimum 0.0001"},
      {"/simulator/time_step", "\"auto\"", "/simulator/time_step: \"auto\" is not a number or null"},
      {"/simulator/iteration", "3",
       "/simulator/iteration: unknown key; known are kind, element, scheme, iterations, tolerance, weight_scale, "
       "threads, time_step, pbd and rigid"},
      {"/material/youngs_modulus", "-6", "/material/youngs_modulus: -6 is not above 0"},
      {"/material/poissons_ratio", "0.5", "/material/poissons_ratio: 0.5 is not below 0.5"},
      {"/material/density", "101", "/material/density: 101 is above the maximum 100"},
      {"/gravity", "[0, 0, -1, 0]", "/gravity: [0,0,-1,0] has 4 items, more than the maximum 3"},
      {"/gravity/0", "200", "/gravity/0: 200 is above the maximum 100"},
      {"/filter/preset", R"("loose")", R"(/filter/preset: "loose" is not one of "standard", "paper" or "force")"},
      {"/filter/process_noise", "-3", "/filter/process_noise: -3 is below the minimum 0"},
      {"/filter/measurement_noise", "101", "/filter/measurement_noise: 101 is above the maximum 100"},
      {"/filter/modes", "1.5", "/filter/modes: 1.5 is not an integer"},
      {"/markers", "3", "/markers: 3 is not a string or an array"},
      {"/markers", R"("set1")", R"(/markers: "set1" is not a marker set of the bundle; there are "all", "few")"},
      {"/markers/1", R"("M3")", R"(/markers/1: "M3" is not a marker of the bundle)"},
      {"/markers/1", R"("M1")", R"(/markers/1: "M1" is given twice)"},
      {"/registration/fit", "\"yes\"", "/registration/fit: \"yes\" is not a boolean or null"},
      {"/registration/rest_frames", "0", "/registration/rest_frames: 0 is below the minimum 1"},
      {"/registration/placement_sd", "-1", "/registration/placement_sd: -1 is below the minimum 0"},
      {"/registration/rest_tolerance", "0", "/registration/rest_tolerance: 0 is not above 0"},
      {"/staleness/stale_after_ms", "0", "/staleness/stale_after_ms: 0 is below the minimum 1"},
      {"/staleness/stale_after_ms", "501", "/staleness/lost_after_ms: 500.0 is below stale_after_ms 501.0"},
      {"/staleness/lost_after_ms", "49", "/staleness/lost_after_ms: 49.0 is below stale_after_ms 50.0"},
      {"/record_max_mb", "0", "/record_max_mb: 0 is below the minimum 0.1"},
      {"/metrics/port", "65536", "/metrics/port: 65536 is above the maximum 65535"},
      {"/log/level", R"("loud")",
       R"(/log/level: "loud" is not one of "trace", "debug", "info", "warn", "error", "critical" or "off")"},
      {"/log/file", R"("")", R"(/log/file: "" has 0 characters, fewer than the minimum 1)"},
      {"/log/max_mb", "0", "/log/max_mb: 0 is below the minimum 0.01"},
      {"/log/files", "0", "/log/files: 0 is below the minimum 1"},
      {"/log/files", "101", "/log/files: 101 is above the maximum 100"},
      {"/realtime/enabled", "1", "/realtime/enabled: 1 is not a boolean"},
      {"/realtime/simulation_cpu", "-1", "/realtime/simulation_cpu: -1 is below the minimum 0"},
      {"/realtime/io_cpu", "1024", "/realtime/io_cpu: 1024 is above the maximum 1023"},
      {"/simulator/threads", "2", "/simulator/threads: 2 is more than realtime.simulation_cpu has room for, 1"},
  };
  const BundleFolder folder;
  for (const Case& bad : cases) {
    CAPTURE(bad.key, bad.value);
    const auto path = folder.write("demo.json", with(kFullConfig, bad.key, bad.value));
    CHECK(refusal([&] { load_daemon_config(path); }) == path.string() + ": " + bad.line);
  }
}

TEST_CASE("Overrides of a configuration pass its checks") {
  const BundleFolder folder;
  const auto path = folder.write("demo.json", kFullConfig);
  const Names good{"simulator.scheme=per-frame", "material.poissons_ratio=0.42", "tracker.frame_deadline_ms=null"};
  const DaemonConfig config = load_daemon_config(path, good);
  CHECK(config.simulator.solver.scheme == Scheme::per_frame);
  CHECK(config.bundle.scene.material.poissons_ratio == 0.42);
  CHECK(config.tracker.frame_deadline == 4ms);

  const Names bad{"simulator.iterations=0"};
  const std::string line = "--set simulator.iterations=0: /simulator/iterations: 0 is below the minimum 1";
  CHECK(refusal([&] { load_daemon_config(path, bad); }) == line);
  CHECK(refusal([&] { config_for_bundle(folder.path(), bad); }) == line);
}

TEST_CASE("Beyond this machine there must be keys, or it must be said that there are none") {
  const BundleFolder folder;
  const std::string client_key = "watcher client 000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f\n";
  const std::string tracker_key = "vicon tracker 100102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f\n";
  const auto write_keys = [&](const std::string& text) {
    const auto path = folder.write("keys", text);
    std::filesystem::permissions(path, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    return "keys=" + path.string();
  };
  const auto load = [&](const Names& overrides) { return config_for_bundle(folder.path(), overrides); };
  CHECK_FALSE(load({}).clients.prove_addresses);
  for (const char* open : {"clients.address=0.0.0.0", "tracker.address=::", "clients.address=10.0.0.1"}) {
    CAPTURE(open);
    CHECK_THROWS_WITH(load({open}), Catch::Contains("can be reached by others than this machine"));
    CHECK_NOTHROW(load({open, "insecure=true"}));
    CHECK_NOTHROW(load({open, write_keys(client_key + tracker_key)}));
  }
  CHECK_NOTHROW(load({"clients.address=127.1.2.3"}));
  CHECK_NOTHROW(load({"clients.address=::1"}));
  CHECK(load({"clients.address=0.0.0.0", "insecure=true"}).clients.prove_addresses);

  const DaemonConfig sealed = load({"clients.address=0.0.0.0", write_keys(client_key + tracker_key)});
  CHECK_FALSE(sealed.clients.prove_addresses);
  REQUIRE(sealed.keys.size() == 2);
  CHECK(sealed.keys[1].name == "vicon");
  CHECK_THROWS_WITH(load({write_keys(client_key)}), Catch::Contains("/keys: none of the keys is a tracker's"));
  CHECK_NOTHROW(load({write_keys(client_key), "tracker.peer=10.0.0.2"}));
  CHECK_THROWS_WITH(load({write_keys(client_key + tracker_key), "clients.max_subscribers=49"}),
                    Catch::Contains("/clients/max_subscribers: 49 is more than there is room for with keys, 48"));
  CHECK_THROWS_WITH(load({"keys=" + (folder.path() / "none").string()}), Catch::Contains("none"));

  // What a recording keeps can be read wherever it is replayed: nothing listens there.
  const DaemonConfig repeated = config_from_text(sealed.document, "recording");
  CHECK(repeated.keys.empty());
  CHECK(repeated.clients.address == "127.0.0.1");
}

TEST_CASE("A simulation pinned to one CPU has one thread, unless nothing is pinned") {
  const BundleFolder folder;
  const auto threads = [&](const Names& overrides) {
    return config_for_bundle(folder.path(), overrides).simulator.solver.threads;
  };
  CHECK(threads({"realtime.simulation_cpu=0", "realtime.enabled=true"}) == 1);
  CHECK(threads({"realtime.simulation_cpu=0", "simulator.threads=2"}) == 2);
  CHECK(threads({"realtime.enabled=true", "realtime.io_cpu=0", "simulator.threads=2"}) == 2);
}

TEST_CASE("Lost is never sooner than stale where only stale is given") {
  const BundleFolder folder;
  const Names overrides{"staleness.stale_after_ms=5000"};
  CHECK(config_for_bundle(folder.path(), overrides).staleness.lost_after == 5s);
}
