// What `tissued` is started with.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/bundle.hpp"
#include "config/key_file.hpp"
#include "core/simulator.hpp"

namespace tissued::config {

struct TrackerConfig {
  std::string address = "127.0.0.1";  // IPv4 or IPv6, where tracker packets are received
  std::uint16_t port = 51001;         // UDP
  // After its first part, a frame that is missing parts is stepped anyway; half a frame period where that is less.
  std::chrono::nanoseconds frame_deadline = std::chrono::milliseconds(4);
  std::string subject;  // labels may come as `subject:label`; the bundle's, unless said otherwise
  // What is not sealed is believed from there alone; empty, 0: from anywhere.
  std::string peer;  // IPv4 or IPv6
  std::uint16_t peer_port = 0;
};

struct ClientsConfig {
  std::string address = "127.0.0.1";
  std::uint16_t port = 51010;  // UDP; 0: any free one
  int max_subscribers = 16;
  // The longest that a subscription is granted; it ends then unless renewed.
  std::chrono::nanoseconds lease = std::chrono::seconds(10);
  int max_requests_per_s = 1000;  // of one client
  // A client must show that it receives where it sends from before it gets anything longer than its question.
  bool prove_addresses = false;
};

struct RegistrationConfig {
  bool fit = false;             // false: bundle.tissue_from_tracker is taken as it is
  int rest_frames = 50;         // frames at rest that are averaged at most
  double placement_sd = 0.5;    // mm per axis, how well markers were glued to their said places
  double rest_tolerance = 0.2;  // mm, tissue; rest ends when a pad is further than this from its rest pose
};

struct StalenessConfig {
  // Without a new frame the answer is stale,
  std::chrono::nanoseconds stale_after = std::chrono::milliseconds(100);
  // and the tracker is lost; not below stale_after.
  std::chrono::nanoseconds lost_after = std::chrono::seconds(1);
};

// Metrics over HTTP, on this machine alone.
struct MetricsConfig {
  std::optional<std::uint16_t> port;  // 0: any free one; nothing: no metrics
};

enum class LogLevel { trace, debug, info, warn, error, critical, off };

struct LogConfig {
  LogLevel level = LogLevel::warn;
  std::filesystem::path file;          // empty: standard error
  std::uint64_t max_bytes = 10000000;  // of one file; then the next is begun
  int files = 5;                       // kept, the one that is written included
};

// What the kernel is asked for, so that other work on this machine cannot hold up a frame.
struct RealtimeConfig {
  bool enabled = false;               // false: nothing is asked for, CPUs included
  std::optional<int> simulation_cpu;  // its thread is pinned to; nothing: the kernel chooses
  std::optional<int> io_cpu;          // the same, of the thread that serves sockets
};

struct DaemonConfig {
  std::string source;           // the file, or the bundle's folder where there was no file; for messages
  std::string document;         // all that was said, JSON with absolute paths: see config_from_text
  std::filesystem::path model;  // what a diagnosis found, see daemon/explained_model.hpp; empty: as the bundle has it
  Bundle bundle;  // material and gravity overridden; scene.markers are the selected ones only, in bundle order
  std::vector<std::string> unused_markers;  // known to the bundle, not selected: expected from the tracker, not used
  TrackerConfig tracker;
  ClientsConfig clients;
  std::filesystem::path key_file;    // empty: none
  std::vector<PreSharedKey> keys;    // of that file; empty: nothing is sealed
  core::SimulatorOptions simulator;  // solver.time_step is filled: 1/rate where none was given
  RegistrationConfig registration;
  // What is known to be wrong of the tracker: markers arrive `marker_delay` s later than pads, and are to be taken for
  // where this, from tracker to tracker coordinates, puts them.
  double marker_delay = 0.0;
  core::RigidTransform marker_correction;
  StalenessConfig staleness;
  std::filesystem::path record;  // where everything that is received and answered is recorded; empty: nowhere
  std::uint64_t record_max_bytes = 1'000'000'000;  // of one file; then the next is begun
  MetricsConfig metrics;
  LogConfig log;
  RealtimeConfig realtime;
};

// Whether only this machine can reach `address`, IPv4 or IPv6.
bool is_loopback(const std::string& address);

// Reads a configuration ("tissued-config/1"; config/schema/tissued.schema.json describes every key) and the bundle that
// it names. overrides: as in load_bundle, with the keys of the configuration, e.g. `material.poissons_ratio=0.42` or
// `simulator.scheme=algorithm-1`. Throws ConfigError.
DaemonConfig load_daemon_config(const std::filesystem::path& path, std::span<const std::string> overrides = {});

// DaemonConfig::document once more, wherever it was kept in the meantime; `source` is for messages. Throws ConfigError.
DaemonConfig config_from_text(const std::string& text, const std::string& source,
                              std::span<const std::string> overrides = {});

// A bundle alone is enough to start from: every key of the configuration at its default. Throws ConfigError.
DaemonConfig config_for_bundle(const std::filesystem::path& folder, std::span<const std::string> overrides = {});

}  // namespace tissued::config
