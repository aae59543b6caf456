#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "protocol/tracker_frame.hpp"
#include "protocol/vicon_stream.hpp"

namespace tissued::protocol {

struct FrameAssemblerConfig {
  // Labelled markers. One that arrives as a Vicon object is taken as a marker.
  std::vector<Name> markers{};
  // Objects (pads, probe) that every frame carries; pads that come and go do not belong here.
  std::vector<Name> objects{};
  // A frame is handed on this long after its first datagram, complete or not.
  std::uint64_t deadline_ns = 4'000'000;
  // A frame number at most this far behind the newest is taken for a late datagram, until `late_frames_for_restart`
  // ascending ones have come without a newer one between. Further behind, or as far ahead, the second one is believed:
  // a single datagram that somebody else sent does not carry the stream away.
  std::uint32_t reorder_window = 64;  // frames
  std::uint32_t late_frames_for_restart = 8;
  // After a silence this long any frame number is followed at once.
  std::uint64_t restart_silence_ns = 500'000'000;
};

// What became of datagrams, items and frames; each is counted.
enum class AssemblerEvent : std::uint8_t {
  datagrams_joined,        // became part of a frame
  duplicate_datagrams,     // this part, or without a stamp every name in it, was there already
  late_datagrams,          // their frame had been handed on, or a newer one had begun
  inconsistent_datagrams,  // another stamp or part count than this frame's other datagrams
  restart_suspects,        // further behind than the reorder window, and not (yet) confirmed as a restart
  jump_suspects,           // further ahead than the reorder window, and not (yet) confirmed by another
  duplicate_items,         // a name twice in one frame; the first stays
  overflowing_items,       // more items than a TrackerFrame holds
  frames_all_parts,        // handed on, by FrameCompletion
  frames_all_names,
  frames_superseded,
  frames_deadline,
  frames_missing,  // frame numbers passed over, in gaps no longer than the reorder window
  forward_jumps,   // longer gaps
  restarts,        // numbering followed backwards
};
inline constexpr std::size_t kAssemblerEventCount = 15;

const char* to_string(AssemblerEvent event);

// Joins the datagrams of one frame number into one TrackerFrame. Pure logic: the caller says what time it is, on any
// clock that does not go back. Frame numbers are compared modulo 2^32, so wrap-around is a step like any other.
//
// One frame is open at a time and the newest wins: a datagram of a newer frame closes the open one. What then still
// comes of an older frame is counted and dropped, but for its markers, which go along with the next frame. Frames come
// out with ascending numbers, except after a restart. A frame is complete when every part that its stamp items announce
// has come (without stamp items: every marker of the config), and every object of the config too. Nothing allocates
// after construction.
class FrameAssembler {
 public:
  explicit FrameAssembler(FrameAssemblerConfig config);

  // Takes a datagram; returns the frames that it finished, oldest first: none, one, or two (the one that it superseded
  // and its own). The frames stay valid until the next call of add or flush_if_due.
  std::span<const TrackerFrame> add(const TrackerDatagram& datagram, std::uint64_t receive_ns);

  // Returns the open frame if its deadline has passed.
  std::span<const TrackerFrame> flush_if_due(std::uint64_t now_ns);

  // When flush_if_due will have something to return; absent while no frame is open.
  std::optional<std::uint64_t> due_ns() const;

  std::uint64_t count(AssemblerEvent event) const { return counts_[static_cast<std::size_t>(event)]; }

 private:
  enum class Place { same, newer, late, far_behind, far_ahead, restart };

  Place place(std::uint32_t frame_number, std::uint64_t receive_ns);
  bool confirms_restart(std::uint32_t frame_number, std::uint32_t frames_back);
  bool confirms_jump(std::uint32_t frame_number);
  bool admit_to_same(const TrackerDatagram& datagram);
  bool adds_nothing(const TrackerDatagram& datagram) const;
  void open(std::uint32_t frame_number, std::uint64_t receive_ns);
  void count_gap(std::uint32_t frame_number);
  void join(const TrackerDatagram& datagram);
  void join_object(const TrackedObject& object);
  void join_marker(const TrackedMarker& marker);
  void keep_late(const TrackerDatagram& datagram);
  template <typename List, typename Item>
  bool join_item(List& list, const Item& item);
  std::optional<FrameCompletion> completion() const;
  void close(FrameCompletion completion);
  void tally(AssemblerEvent event, std::uint64_t times = 1) { counts_[static_cast<std::size_t>(event)] += times; }

  FrameAssemblerConfig config_;
  TrackerFrame frame_;    // the newest: open, or closed and kept to know its late and duplicate datagrams
  LateMarkers late_;      // for the next frame that is handed on
  bool started_ = false;  // frame_ holds a frame at all
  bool open_ = false;
  std::uint8_t part_count_ = 0;              // of frame_; 0 before a stamp item has come
  std::bitset<256> parts_;                   // of frame_, those that came
  std::size_t markers_seen_ = 0;             // of config_.markers, in frame_
  std::size_t objects_seen_ = 0;             // of config_.objects, in frame_
  std::uint64_t progress_ns_ = 0;            // when a datagram last joined
  std::uint32_t behind_run_ = 0;             // ascending older frame numbers since then
  std::uint32_t behind_last_ = 0;            // the last of them
  std::optional<std::uint32_t> ahead_last_;  // the last frame number since then that was too far ahead
  std::array<TrackerFrame, 2> ready_;
  std::size_t ready_count_ = 0;
  std::array<std::uint64_t, kAssemblerEventCount> counts_{};
};

}  // namespace tissued::protocol
