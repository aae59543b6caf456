#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace tissued::daemon {

/// How a recorded run went when it was repeated.
struct ReplayReport {
  std::size_t frames = 0;                      ///< of the tracker, as the recorded datagrams were joined
  std::size_t steps = 0;                       ///< answers in the recording, each repeated
  std::size_t equal = 0;                       ///< of them equal in every bit but the time that they took
  std::optional<std::uint32_t> first_unequal;  ///< tracker frame
  std::string difference;                      ///< of that one, in words
  std::uint64_t state_hash = 0;                ///< at the end of the repetition
  std::optional<std::uint64_t> recorded_hash;  ///< nothing where the daemon was killed
  std::uint64_t lost = 0;                      ///< records that the daemon found no room for
  std::size_t damaged_bytes = 0;               ///< that belong to no whole record
  bool torn = false;                           ///< the end is missing

  bool is_same() const { return equal == steps && (!recorded_hash || *recorded_hash == state_hash); }
};

/// Repeats what `tissued --record FILE` has recorded, with the configuration that is in it: the frames that were
/// stepped then, joined from the datagrams that came then, one after the other. bundle: where the one that was recorded
/// with is now; empty: where it was then. on_step(done, of): after every step.
/// Throws std::runtime_error where the file is no recording, is of another bundle, or lacks the datagrams of a frame
/// that was stepped; config::ConfigError, core::ModelError and what reading a mesh throws.
ReplayReport replay_session(const std::filesystem::path& file, const std::filesystem::path& bundle,
                            const std::function<void(std::size_t, std::size_t)>& on_step);

}  // namespace tissued::daemon
