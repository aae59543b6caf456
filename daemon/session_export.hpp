#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "config/daemon_config.hpp"
#include "daemon/recording_reader.hpp"
#include "protocol/trial.hpp"

namespace tissued::daemon {

/// What became of a recording of a live session.
struct ExportReport {
  double seconds = 0.0;           ///< from the first tracker frame to the last
  std::size_t records = 0;        ///< whole ones
  std::size_t frames = 0;         ///< of the tracker
  std::uint64_t lost = 0;         ///< records that the daemon says it found no room for
  std::size_t damaged_bytes = 0;  ///< that belong to no whole record
  bool torn = false;              ///< the end is missing
  std::vector<std::string> trials, held_out;
};

/// Every frame of the tracker, as tissued joined them from the recorded datagrams, at a constant rate: frames that did
/// not come are gaps. Labels are the bundle's markers, pads and targets. Throws std::runtime_error where there is none.
protocol::Trial trial_of_session(const config::DaemonConfig& config, RecordingReader& reader, ExportReport& report);

/// Frames [begin, end).
struct Stretch {
  std::size_t begin = 0, end = 0;
};

/// The pushes: where a pad is further than the config's rest tolerance from its rest pose, with half a second of rest
/// before and after; parted by a second of rest. All of it where no pad moves.
std::vector<Stretch> find_pushes(const config::DaemonConfig& config, const protocol::Trial& session);

/// Makes a bundle of a recorded session: a copy of bundle.json and mesh, and a Nexus CSV for every push, every fourth
/// one held out. bundle: the one that was recorded with; checked by its hash. `out` is made; throws
/// std::runtime_error where it holds a bundle.json already, or the recording is of another bundle; FileError.
ExportReport export_session(const std::filesystem::path& file, const std::filesystem::path& bundle,
                            const std::filesystem::path& out);

}  // namespace tissued::daemon
