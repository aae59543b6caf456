#include "config/daemon_config.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "config/document.hpp"
#include "config/geometry.hpp"
#include "config/schema.hpp"

namespace tissued::config {
namespace {

namespace fs = std::filesystem;

using Milliseconds = std::chrono::duration<double, std::milli>;
using Seconds = std::chrono::duration<double>;

// A duration that the document gives as a number of `Unit`.
template <typename Unit>
Unit duration(const Document& document, const std::string& key, Unit fallback) {
  return Unit(document.value(key, fallback.count()));
}

std::chrono::nanoseconds to_nanoseconds(Seconds seconds) {
  return std::chrono::nanoseconds(std::llround(seconds.count() * 1e9));
}

std::string read_address(const Document& document, const std::string& key, const std::string& fallback) {
  const std::string address = document.value(key, fallback);
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  const bool is_address =
      inet_pton(AF_INET, address.c_str(), bytes.data()) == 1 || inet_pton(AF_INET6, address.c_str(), bytes.data()) == 1;
  if (!is_address) document.refuse(JsonPointer(key), quoted(Json(address)) + " is not an IPv4 or IPv6 address");
  return address;
}

TrackerConfig read_tracker(const Document& document, const Bundle& bundle) {
  TrackerConfig tracker;
  tracker.address = read_address(document, "/tracker/address", tracker.address);
  tracker.port = document.value("/tracker/port", tracker.port);
  tracker.subject = document.value("/tracker/subject", bundle.subject);
  if (document.find("/tracker/peer")) tracker.peer = read_address(document, "/tracker/peer", "");
  tracker.peer_port = document.value("/tracker/peer_port", tracker.peer_port);
  const Milliseconds period(1e3 / bundle.scene.rate);
  const auto usual = std::min<Milliseconds>(tracker.frame_deadline, 0.5 * period);
  const auto deadline = duration(document, "/tracker/frame_deadline_ms", usual);
  if (deadline >= period) {
    document.refuse(JsonPointer("/tracker/frame_deadline_ms"), quoted(Json(deadline.count())) +
                                                                   " is not below the frame period of the bundle, " +
                                                                   quoted(Json(period.count())));
  }
  tracker.frame_deadline = to_nanoseconds(deadline);
  return tracker;
}

ClientsConfig read_clients(const Document& document) {
  ClientsConfig clients;
  clients.address = read_address(document, "/clients/address", clients.address);
  clients.port = document.value("/clients/port", clients.port);
  clients.max_subscribers = document.value("/clients/max_subscribers", clients.max_subscribers);
  clients.lease = to_nanoseconds(duration<Seconds>(document, "/clients/lease_s", clients.lease));
  clients.max_requests_per_s = document.value("/clients/max_requests_per_s", clients.max_requests_per_s);
  return clients;
}

constexpr int kMostSealedSubscribers = 48;  // their contacts keep their places, and newcomers need some, too

void read_keys(const Document& document, DaemonConfig& config) {
  if (!config.key_file.empty()) {
    config.keys = read_key_file(config.key_file);
    if (config.keys.empty()) document.refuse(JsonPointer("/keys"), config.key_file.string() + " holds no key");
  }
  const bool has_keys = !config.keys.empty();
  const auto has_role = [](KeyRole role) {
    return [role](const PreSharedKey& key) { return key.role == role || key.role == KeyRole::both; };
  };
  const bool seals_tracker = std::any_of(config.keys.begin(), config.keys.end(), has_role(KeyRole::tracker));
  const bool tracker_named = !config.tracker.peer.empty();
  if (has_keys && !seals_tracker && !tracker_named) {
    document.refuse(JsonPointer("/keys"),
                    "none of the keys is a tracker's, and no tracker.peer is given: nobody "
                    "could send a frame");
  }
  if (has_keys && config.clients.max_subscribers > kMostSealedSubscribers) {
    document.refuse(JsonPointer("/clients/max_subscribers"), quoted(Json(config.clients.max_subscribers)) +
                                                                 " is more than there is room for with keys, " +
                                                                 quoted(Json(kMostSealedSubscribers)));
  }
  const bool insecure = document.value("/insecure", false);
  const auto refuse_open = [&](const char* key, const std::string& address) {
    if (has_keys || insecure || is_loopback(address)) return;
    document.refuse(JsonPointer(key), quoted(Json(address)) +
                                          " can be reached by others than this machine: give a file of `keys`, or say "
                                          "`insecure` (--insecure) and believe anybody");
  };
  refuse_open("/tracker/address", config.tracker.address);
  refuse_open("/clients/address", config.clients.address);
  config.clients.prove_addresses =
      document.value("/clients/prove_addresses", !has_keys && !is_loopback(config.clients.address));
}

core::FemSimulatorOptions read_fem(const Document& document) {
  core::FemSimulatorOptions options;
  if (document.value<std::string>("/fem/element", "p2") == "p1") options.element = core::FemElement::p1;
  const auto dynamics = document.value<std::string>("/fem/dynamics", "quasi-static");
  core::TimeScheme scheme;
  if (dynamics == "implicit-euler") scheme.kind = core::TimeScheme::Kind::implicit_euler;
  scheme.spectral_radius = document.value("/fem/spectral_radius", scheme.spectral_radius);
  if (dynamics != "quasi-static") options.dynamics = scheme;
  options.damping.mass = document.value("/fem/mass_damping", options.damping.mass);
  options.damping.stiffness = document.value("/fem/stiffness_damping", options.damping.stiffness);
  return options;
}

core::PbdOptions read_pbd(const Document& document) {
  core::PbdOptions options;
  const auto read = [&document](const char* key, auto& option) {
    option = document.value("/simulator/pbd/" + std::string(key), option);
  };
  read("particle_spacing", options.particle_spacing);
  read("cluster_spacing", options.cluster_spacing);
  read("cluster_radius", options.cluster_radius);
  read("cluster_stiffness", options.cluster_stiffness);
  read("time_step", options.time_step);
  read("substeps", options.substeps);
  read("iterations", options.iterations);
  read("damping", options.damping);
  read("collision_distance", options.collision_distance);
  read("shape_friction", options.shape_friction);
  read("particle_friction", options.particle_friction);
  read("self_collision", options.self_collision);
  if (document.value<std::string>("/simulator/pbd/readout", "blend") == "nearest")
    options.readout = core::PbdReadout::nearest;
  if (options.cluster_radius < 0.5 * options.cluster_spacing) {
    document.refuse(JsonPointer("/simulator/pbd/cluster_radius"), quoted(Json(options.cluster_radius)) +
                                                                      " is below half of cluster_spacing, " +
                                                                      quoted(Json(0.5 * options.cluster_spacing)));
  }
  if (options.damping * options.substep() > 1.0) {
    document.refuse(
        JsonPointer("/simulator/pbd/damping"),
        quoted(Json(options.damping)) + " is above one over a substep, " + quoted(Json(1.0 / options.substep())));
  }
  return options;
}

core::SimulatorOptions read_simulator(const Document& document, const Bundle& bundle) {
  core::SimulatorOptions options;
  options.kind = document.value("/simulator/kind", options.kind);
  if (document.value<std::string>("/simulator/element", "smoothed") == "p1") options.solver.element = core::Element::p1;
  const bool as_printed = document.value<std::string>("/simulator/scheme", "per-frame") == "algorithm-1";
  options.solver.scheme = as_printed ? core::Scheme::algorithm_1 : core::Scheme::per_frame;
  options.solver.iterations = document.value("/simulator/iterations", options.solver.iterations);
  options.solver.tolerance = document.value("/simulator/tolerance", options.solver.tolerance);
  options.solver.weight_scale = document.value("/simulator/weight_scale", options.solver.weight_scale);
  options.solver.threads = document.value("/simulator/threads", options.solver.threads);
  options.solver.time_step = document.value("/simulator/time_step", 1.0 / bundle.scene.rate);
  const auto preset = document.value<std::string>("/filter/preset", "standard");
  options.filter.preset = preset == "paper"   ? core::NoisePreset::paper
                          : preset == "force" ? core::NoisePreset::force
                                              : core::NoisePreset::standard;
  options.filter.process_noise = document.value("/filter/process_noise", options.filter.process_noise);
  options.filter.measurement_noise = document.value("/filter/measurement_noise", options.filter.measurement_noise);
  options.filter.modes = document.value("/filter/modes", options.filter.modes);
  options.filter.stiffness_sd = document.value("/filter/stiffness_sd", options.filter.stiffness_sd);
  options.filter.stiffness_length = document.value("/filter/stiffness_length", options.filter.stiffness_length);
  options.filter.slip = document.value("/filter/slip", options.filter.slip);
  options.filter.discrepancy = document.value("/filter/discrepancy", options.filter.discrepancy);
  options.alarm.enabled = document.value("/alarm/enabled", true);
  options.alarm.model_error = document.value("/alarm/model_error", options.alarm.model_error);
  options.fem = read_fem(document);
  options.pbd = read_pbd(document);
  if (document.value<std::string>("/simulator/rigid/follow", "none") == "markers")
    options.rigid.follow = core::RigidOptions::Follow::markers;
  return options;
}

RegistrationConfig read_registration(const Document& document, const Bundle& bundle) {
  RegistrationConfig registration;
  registration.fit = document.value("/registration/fit", bundle.has_tracker_pose);
  registration.rest_frames = document.value("/registration/rest_frames", registration.rest_frames);
  registration.placement_sd = document.value("/registration/placement_sd", registration.placement_sd);
  registration.rest_tolerance = document.value("/registration/rest_tolerance", registration.rest_tolerance);
  return registration;
}

StalenessConfig read_staleness(const Document& document) {
  StalenessConfig staleness;
  const auto stale = duration<Milliseconds>(document, "/staleness/stale_after_ms", staleness.stale_after);
  const auto usual = std::max<Milliseconds>(staleness.lost_after, stale);
  const auto lost = duration(document, "/staleness/lost_after_ms", usual);
  if (lost < stale) {
    document.refuse(JsonPointer("/staleness/lost_after_ms"),
                    quoted(Json(lost.count())) + " is below stale_after_ms " + quoted(Json(stale.count())));
  }
  return {to_nanoseconds(stale), to_nanoseconds(lost)};
}

std::optional<std::uint16_t> read_metrics_port(const Document& document) {
  const int port = document.value("/metrics/port", -1);
  return port < 0 ? std::nullopt : std::optional(static_cast<std::uint16_t>(port));
}

LogLevel read_log_level(const Document& document) {
  constexpr std::array<std::string_view, 7> names{"trace", "debug", "info", "warn", "error", "critical", "off"};
  const std::string name = document.value<std::string>("/log/level", "warn");
  return static_cast<LogLevel>(std::find(names.begin(), names.end(), name) - names.begin());
}

LogConfig read_log(const Document& document) {
  LogConfig log;
  log.level = read_log_level(document);
  const double most_mb = document.value("/log/max_mb", 1e-6 * static_cast<double>(log.max_bytes));
  log.max_bytes = static_cast<std::uint64_t>(std::llround(1e6 * most_mb));
  log.files = document.value("/log/files", log.files);
  return log;
}

std::optional<int> read_cpu(const Document& document, const std::string& key) {
  const Json* cpu = document.find(key);
  return cpu ? std::optional(cpu->get<int>()) : std::nullopt;
}

// Threads of the parallel loops wait for each other by spinning: on one CPU, in real time, for good.
int threads_on_one_cpu(const Document& document, int threads) {
  if (threads > 1) {
    document.refuse(JsonPointer("/simulator/threads"),
                    quoted(Json(threads)) + " is more than realtime.simulation_cpu has room for, 1");
  }
  return 1;
}

RealtimeConfig read_realtime(const Document& document) {
  RealtimeConfig realtime;
  realtime.enabled = document.value("/realtime/enabled", realtime.enabled);
  realtime.simulation_cpu = read_cpu(document, "/realtime/simulation_cpu");
  realtime.io_cpu = read_cpu(document, "/realtime/io_cpu");
  return realtime;
}

void override_assumptions(const Document& document, core::Scene& scene) {
  core::Material& material = scene.material;
  material.youngs_modulus = document.value("/material/youngs_modulus", material.youngs_modulus);
  material.poissons_ratio = document.value("/material/poissons_ratio", material.poissons_ratio);
  material.density = document.value("/material/density", material.density);
  if (const Json* gravity = document.find("/gravity")) scene.gravity = to_vector(*gravity);
}

std::vector<std::string> named_markers(const Document& document, const Bundle& bundle) {
  const JsonPointer key("/markers");
  const Json* chosen = document.find("/markers");
  std::vector<std::string> names;
  for (const core::Marker& marker : bundle.scene.markers) names.push_back(marker.name);
  if (!chosen || *chosen == "all") return names;
  if (chosen->is_string()) {
    if (const MarkerSet* set = bundle.find_marker_set(chosen->get<std::string>())) return set->markers;
    std::string known = "\"all\"";
    for (const MarkerSet& set : bundle.marker_sets) known += ", " + quoted(Json(set.name));
    document.refuse(key, quoted(*chosen) + " is not a marker set of the bundle; there are " + known);
  }
  for (std::size_t i = 0; i < chosen->size(); ++i) {
    if (std::find(names.begin(), names.end(), (*chosen)[i].get<std::string>()) == names.end()) {
      document.refuse(key / i, quoted((*chosen)[i]) + " is not a marker of the bundle");
    }
  }
  return chosen->get<std::vector<std::string>>();
}

// Moves the markers that are not chosen out of the scene.
std::vector<std::string> select_markers(const Document& document, Bundle& bundle) {
  const std::vector<std::string> chosen = named_markers(document, bundle);
  std::vector<core::Marker> used;
  std::vector<std::string> unused;
  for (core::Marker& marker : bundle.scene.markers) {
    if (std::find(chosen.begin(), chosen.end(), marker.name) != chosen.end()) {
      used.push_back(std::move(marker));
    } else {
      unused.push_back(marker.name);
    }
  }
  bundle.scene.markers = std::move(used);
  return unused;
}

// The document without what one run alone may have, from wherever it is read.
std::string repeatable(const Document& document, const DaemonConfig& config) {
  Json root = document.root();
  root["bundle"] = fs::absolute(config.bundle.folder).lexically_normal().string();
  if (!config.model.empty()) root["model"] = fs::absolute(config.model).lexically_normal().string();
  for (const char* own : {"record", "record_max_mb", "keys", "clients"}) root.erase(own);
  if (root.contains("tracker")) {
    for (const char* own : {"address", "peer", "peer_port"}) root["tracker"].erase(own);
    if (root["tracker"].empty()) root.erase("tracker");
  }
  // A folder may have any bytes for its name; JSON may not.
  return root.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// base: what relative paths are relative to; empty: the working folder.
DaemonConfig read_config(const Document& document, const fs::path& base) {
  DaemonConfig config;
  config.source = document.source();
  const auto place_of = [&](const char* key) {
    const auto path = document.value<std::string>(key, "");
    return path.empty() ? fs::path() : base / path;
  };
  config.model = place_of("/model");
  config.record = place_of("/record");
  const double record_mb = document.value("/record_max_mb", 1e-6 * static_cast<double>(config.record_max_bytes));
  config.record_max_bytes = static_cast<std::uint64_t>(std::llround(1e6 * record_mb));
  if (const fs::path folder = place_of("/bundle"); !fs::exists(folder / "bundle.json"))
    document.refuse(JsonPointer("/bundle"), folder.string() + " holds no bundle.json");
  config.bundle = load_bundle(place_of("/bundle"));
  config.document = repeatable(document, config);
  config.unused_markers = select_markers(document, config.bundle);
  override_assumptions(document, config.bundle.scene);
  config.tracker = read_tracker(document, config.bundle);
  config.clients = read_clients(document);
  if (config.clients.port == config.tracker.port && config.clients.port != 0)
    document.refuse(JsonPointer("/clients/port"), std::to_string(config.clients.port) + " is the tracker's port, too");
  config.key_file = place_of("/keys");
  read_keys(document, config);
  config.simulator = read_simulator(document, config.bundle);
  config.registration = read_registration(document, config.bundle);
  config.staleness = read_staleness(document);
  config.metrics.port = read_metrics_port(document);
  config.log = read_log(document);
  config.log.file = place_of("/log/file");
  config.realtime = read_realtime(document);
  int& threads = config.simulator.solver.threads;
  if (config.realtime.enabled && config.realtime.simulation_cpu) threads = threads_on_one_cpu(document, threads);
  return config;
}

}  // namespace

bool is_loopback(const std::string& address) {
  in_addr v4{};
  if (inet_pton(AF_INET, address.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == IN_LOOPBACKNET;
  in6_addr v6{};
  return inet_pton(AF_INET6, address.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

DaemonConfig load_daemon_config(const fs::path& path, std::span<const std::string> overrides) {
  return read_config(Document(read_json(path), path.string(), overrides, config_schema()), path.parent_path());
}

DaemonConfig config_from_text(const std::string& text, const std::string& source,
                              std::span<const std::string> overrides) {
  return read_config(Document(parse_json(text, source), source, overrides, config_schema()), {});
}

DaemonConfig config_for_bundle(const fs::path& folder, std::span<const std::string> overrides) {
  const Json defaults = {{"format", "tissued-config/1"}, {"bundle", folder.string()}};
  return read_config(Document(defaults, folder.string(), overrides, config_schema()), {});
}

}  // namespace tissued::config
