#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>

#include "protocol/client_header.hpp"
#include "protocol/frame_assembler.hpp"
#include "protocol/sealed_datagram.hpp"
#include "protocol/vicon_stream.hpp"

namespace tissued::daemon {

/// What the daemon itself counts; what protocol's gates and the frame assembler count stands beside it in the table.
enum class Count : std::uint8_t {
  tracker_datagrams,    ///< received, whatever became of them
  foreign_datagrams,    ///< tracker datagrams from elsewhere than the stream's source, see SourcePin
  kernel_drops,         ///< tracker datagrams dropped by the kernel: the socket was full, or others were shut out
  unknown_items,        ///< items of an id that the tracker's protocol does not define
  frames_stepped,       ///< tracker frames that the simulation took
  frames_skipped,       ///< frames for which it had no time: a newer one was there
  unknown_names,        ///< markers, pads or targets that the scene does not have
  delayed_markers,      ///< older than their frame's pads: compared with the simulation of their own time
  markers_too_late,     ///< so old that the simulation does not remember: not used
  late_markers,         ///< seen, but withheld: first shown when the rest calibration was over
  pads_held,            ///< pads not seen whose last pose or force was used again
  stamps_refused,       ///< tracker stamps that stood still, ran backwards or jumped: dt came from frame numbers
  dt_clamped,           ///< steps told another dt than was measured
  rate_changes,         ///< nominal time steps adopted
  rate_changes_failed,  ///< nominal time steps that the simulator refused
  steps_not_finite,     ///< steps thrown away, not finite or far beyond the body; the last good answer was held
  steps_braked,         ///< steps ended because they took too long; the last good answer was held
  answers_unseen,       ///< answers replaced before the I/O thread had taken them
  client_datagrams,     ///< received, whatever became of them
  challenges_sent,      ///< to those whose contact is not known, see SealedPort
  requests_unproven,    ///< requests from an address that was not shown to receive
  requests_limited,     ///< requests of a client that asks too often
  requests_repeated,    ///< requests dropped because their sequence number was not new
  clients_refused,      ///< subscriptions for which there was no room
  leases_expired,       ///< subscriptions that ended because nobody renewed them
  datagrams_sent,       ///< to clients
  sends_failed,         ///< datagrams to clients that the kernel did not take
  transfers_refused,    ///< mesh or topology answers not begun because the last one was still on its way
  records_written,      ///< of the recording, see SessionRecorder
  records_lost,         ///< that found no room, or came when the recording had ended
  recording_failed,     ///< 1: the recording ended because its file could not be written
  // Not counts, but said along with them:
  rest_frames,          ///< frames at rest that the calibration stands on
  registration_rms_um,  ///< distance of markers at rest from their said places, after a fit where one is made
};
inline constexpr std::size_t kCountCount = 33;

/// Everything that happened, was skipped or was refused, by reason, since the start. Any thread adds, any reads.
class Counters {
 public:
  static constexpr std::size_t kSize = kCountCount + protocol::kAssemblerEventCount + protocol::kTrackerRefusalCount +
                                       protocol::kClientRefusalCount + protocol::kSealRefusalCount;

  void add(Count count, std::uint64_t times = 1) noexcept { add(index_of(count), times); }
  void add(protocol::TrackerRefusal refusal) noexcept { add(index_of(refusal), 1); }
  void add(protocol::ClientRefusal refusal) noexcept { add(index_of(refusal), 1); }
  void add(protocol::SealRefusal refusal) noexcept { add(index_of(refusal), 1); }
  /// For sums kept elsewhere.
  void set(Count count, std::uint64_t total) noexcept { set(index_of(count), total); }
  void set(protocol::AssemblerEvent event, std::uint64_t total) noexcept { set(index_of(event), total); }

  std::uint64_t operator[](Count count) const noexcept { return value(index_of(count)); }
  std::uint64_t operator[](protocol::AssemblerEvent event) const noexcept { return value(index_of(event)); }
  std::uint64_t operator[](protocol::TrackerRefusal refusal) const noexcept { return value(index_of(refusal)); }
  std::uint64_t operator[](protocol::ClientRefusal refusal) const noexcept { return value(index_of(refusal)); }
  std::uint64_t operator[](protocol::SealRefusal refusal) const noexcept { return value(index_of(refusal)); }

  /// By place in the table, 0 .. kSize - 1.
  std::uint64_t value(std::size_t index) const noexcept { return values_[index].load(std::memory_order_relaxed); }
  /// At most 24 characters: `frames_skipped`; of a gate `tracker:too_short`, `client:bad_magic`, `seal:replayed`, and
  /// `tracker:accepted`, `client:accepted`, `seal:accepted` for what passed all gates.
  static std::string name(std::size_t index);

 private:
  static constexpr std::size_t kFirstEvent = kCountCount;
  static constexpr std::size_t kFirstTrackerRefusal = kFirstEvent + protocol::kAssemblerEventCount;
  static constexpr std::size_t kFirstClientRefusal = kFirstTrackerRefusal + protocol::kTrackerRefusalCount;
  static constexpr std::size_t kFirstSealRefusal = kFirstClientRefusal + protocol::kClientRefusalCount;

  static constexpr std::size_t index_of(Count count) { return static_cast<std::size_t>(count); }
  static constexpr std::size_t index_of(protocol::AssemblerEvent event) {
    return kFirstEvent + static_cast<std::size_t>(event);
  }
  static constexpr std::size_t index_of(protocol::TrackerRefusal refusal) {
    return kFirstTrackerRefusal + static_cast<std::size_t>(refusal);
  }
  static constexpr std::size_t index_of(protocol::ClientRefusal refusal) {
    return kFirstClientRefusal + static_cast<std::size_t>(refusal);
  }
  static constexpr std::size_t index_of(protocol::SealRefusal refusal) {
    return kFirstSealRefusal + static_cast<std::size_t>(refusal);
  }

  void add(std::size_t index, std::uint64_t times) noexcept {
    values_[index].fetch_add(times, std::memory_order_relaxed);
  }
  void set(std::size_t index, std::uint64_t total) noexcept { values_[index].store(total, std::memory_order_relaxed); }

  std::array<std::atomic<std::uint64_t>, kSize> values_{};
};

}  // namespace tissued::daemon
