// Any bytes as a stream of tracker datagrams, each behind two bytes of time (ms since the one before) and two of
// length: what is accepted keeps its promises, and so do the frames that the assembler hands on.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "protocol/bytes.hpp"
#include "protocol/frame_assembler.hpp"
#include "protocol/vicon_stream.hpp"
#include "tests/fuzz/promise.hpp"

using namespace tissued::protocol;
using tissued::fuzz::promise;

namespace {

void check_numbers(const std::array<double, 3>& values, double limit) {
  for (const double value : values) promise(std::isfinite(value) && std::abs(value) <= limit, "numbers are in limits");
}

template <typename List>
void check_names(const List& list, bool distinct) {
  for (const auto& item : list) {
    promise(!item.name.empty(), "names are not empty");
    const auto same = std::count_if(list.begin(), list.end(), [&](const auto& o) { return o.name == item.name; });
    promise(!distinct || same == 1, "a frame has each name once");
  }
}

template <typename Items>
void check_items(const Items& items, bool distinct) {
  check_names(items.objects, distinct);
  check_names(items.markers, distinct);
  check_names(items.forces, distinct);
  check_names(items.truth, distinct);
  for (const auto& object : items.objects) check_numbers(object.position, kMaxPosition);
  for (const auto& object : items.objects) check_numbers(object.rotation_rad, kMaxRotation_rad);
  for (const auto& marker : items.markers) check_numbers(marker.position, kMaxPosition);
  for (const auto& force : items.forces) check_numbers(force.force, kMaxForce);
  for (const auto& truth : items.truth) check_numbers(truth.position, kMaxPosition);
}

class Receiver {
 public:
  void take(std::span<const std::uint8_t> bytes, std::uint64_t now_ns) {
    check_frames(assembler_.flush_if_due(now_ns));
    TrackerDatagram datagram;
    if (decode_tracker_datagram(bytes, datagram) != TrackerRefusal::none) return;
    check_items(datagram, false);
    ++accepted_;
    check_frames(assembler_.add(datagram, now_ns));
    promise(sum({AssemblerEvent::datagrams_joined, AssemblerEvent::duplicate_datagrams, AssemblerEvent::late_datagrams,
                 AssemblerEvent::inconsistent_datagrams, AssemblerEvent::restart_suspects,
                 AssemblerEvent::jump_suspects}) == accepted_,
            "every datagram is counted once");
    promise(sum({AssemblerEvent::frames_all_names, AssemblerEvent::frames_all_parts, AssemblerEvent::frames_deadline,
                 AssemblerEvent::frames_superseded}) == frames_,
            "every frame is counted once");
  }

 private:
  void check_frames(std::span<const TrackerFrame> frames) {
    promise(frames.size() <= 2, "a datagram finishes two frames at most");
    for (const TrackerFrame& frame : frames) {
      check_items(frame, true);
      const bool newer = !last_ || (frame.frame_number != *last_ && frame.frame_number - *last_ < 0x80000000U);
      promise(newer || frame.after_restart, "frames ascend, or say that the tracker restarted");
      last_ = frame.frame_number;
      ++frames_;
    }
  }

  std::uint64_t sum(std::initializer_list<AssemblerEvent> events) const {
    std::uint64_t total = 0;
    for (const AssemblerEvent event : events) total += assembler_.count(event);
    return total;
  }

  FrameAssembler assembler_{{.markers = {Name::from("M01").value()}, .objects = {}}};
  std::optional<std::uint32_t> last_;
  std::uint64_t accepted_ = 0;
  std::uint64_t frames_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Receiver receiver;
  ByteReader reader({data, size});
  std::uint64_t now_ns = 0;
  while (reader.remaining() >= 4) {
    now_ns += 1'000'000ULL * reader.u16();
    const std::size_t length = reader.u16();
    receiver.take(reader.bytes(std::min(length, reader.remaining())), now_ns);
  }
  return 0;
}
