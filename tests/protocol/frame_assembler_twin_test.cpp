// The assembler against a twin that says, frame by frame and from the whole history, what must come out.

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "protocol/frame_assembler.hpp"

using namespace tissued::protocol;

namespace {

constexpr std::uint64_t kDeadline = 4000;

// A datagram that arrives, or (part_count == 0) a look at the clock.
struct Event {
  std::uint64_t time = 0;
  std::int64_t frame = 0;  // never wraps
  std::uint8_t part = 0;
  std::uint8_t part_count = 0;
  bool is_flush() const { return part_count == 0; }
};

struct Emitted {
  std::size_t at = 0;  // index of the event that let it out
  std::int64_t frame = 0;
  std::set<int> parts;
  FrameCompletion completion = FrameCompletion::all_parts;
  bool operator==(const Emitted&) const = default;
};

// What becomes of one frame, seen by itself: it opens with its first datagram that no newer frame preceded, and ends
// with the first event that completes it, is newer, or looks at the clock past its deadline.
std::optional<Emitted> fate_of(std::int64_t frame, const std::vector<Event>& events) {
  std::optional<Emitted> open;
  std::uint64_t opened_at = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Event& event = events[i];
    if (event.is_flush()) {
      if (open && event.time >= opened_at + kDeadline) return Emitted{i, frame, open->parts, FrameCompletion::deadline};
      continue;
    }
    if (event.frame > frame) {
      if (open) return Emitted{i, frame, open->parts, FrameCompletion::superseded};
      return std::nullopt;
    }
    if (event.frame != frame) continue;
    if (!open) {
      open.emplace();
      opened_at = event.time;
    }
    open->parts.insert(event.part);
    if (open->parts.size() == event.part_count) {
      return Emitted{i, frame, open->parts, FrameCompletion::all_parts};
    }
  }
  return std::nullopt;
}

// A network: every frame leaves in 1 to 4 parts; each part is lost, doubled and delayed as chance has it.
std::vector<Event> noisy_stream(unsigned seed, std::int64_t first_frame) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> chance(0, 1);
  std::uniform_int_distribution<int> parts(1, 4);
  std::exponential_distribution<double> delay(1.0 / (seed % 2 == 0 ? 500.0 : 8000.0));
  std::vector<Event> events;
  for (std::int64_t k = 0; k < 200; ++k) {
    const auto part_count = static_cast<std::uint8_t>(parts(random));
    for (std::uint8_t part = 0; part < part_count; ++part) {
      const int copies = chance(random) < 0.05 ? 0 : (chance(random) < 0.1 ? 2 : 1);
      for (int copy = 0; copy < copies; ++copy) {
        // At most 40 ms: four frames back, short of what counts as a restart.
        const double late = std::min(delay(random), 40000.0);
        const auto time = static_cast<std::uint64_t>(1e6 + 10000.0 * static_cast<double>(k) + 100.0 * part + late);
        events.push_back({time, first_frame + k, part, part_count});
      }
    }
  }
  for (std::uint64_t time = 1'000'000; time < 3'100'000; time += 700) events.push_back({time, 0, 0, 0});
  std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.time < b.time; });
  return events;
}

std::vector<Emitted> expected(const std::vector<Event>& events) {
  std::set<std::int64_t> frames;
  for (const Event& event : events) {
    if (!event.is_flush()) frames.insert(event.frame);
  }
  std::vector<Emitted> all;
  for (const std::int64_t frame : frames) {
    if (const auto fate = fate_of(frame, events)) all.push_back(*fate);
  }
  return all;
}

TrackerDatagram datagram_of(const Event& event) {
  TrackerDatagram datagram;
  datagram.frame_number = static_cast<std::uint32_t>(event.frame);
  datagram.stamp = FrameStamp{static_cast<std::uint64_t>(event.frame), event.part, event.part_count};
  constexpr std::array kNames{"M0", "M1", "M2", "M3"};
  datagram.markers.push_back(
      {Name::from(kNames[event.part]).value(), {static_cast<double>(event.frame), 1.0 * event.part, 0}, false});
  return datagram;
}

// The parts that a frame holds, told from its markers; -1 among them where a marker belongs to another frame.
std::set<int> parts_of(const TrackerFrame& frame, std::int64_t number) {
  std::set<int> parts;
  for (const TrackedMarker& marker : frame.markers) {
    parts.insert(marker.position[0] == static_cast<double>(number) ? static_cast<int>(marker.position[1]) : -1);
  }
  return parts;
}

}  // namespace

TEST_CASE("under loss, duplicates and reorder the assembler does what its twin says") {
  // The second numbering passes through 2^32.
  for (const std::int64_t first_frame : {std::int64_t{1}, (std::int64_t{1} << 32) - 100}) {
    for (unsigned seed = 0; seed < 30; ++seed) {
      const auto events = noisy_stream(seed, first_frame);
      FrameAssembler assembler({.deadline_ns = kDeadline, .restart_silence_ns = 1'000'000'000});
      std::vector<Emitted> emitted;
      std::uint64_t arrivals = 0;
      for (std::size_t i = 0; i < events.size(); ++i) {
        const Event& event = events[i];
        arrivals += event.is_flush() ? 0 : 1;
        const auto frames =
            event.is_flush() ? assembler.flush_if_due(event.time) : assembler.add(datagram_of(event), event.time);
        for (const TrackerFrame& frame : frames) {
          const auto number = static_cast<std::int64_t>(*frame.stamp_ns);
          REQUIRE(frame.frame_number == static_cast<std::uint32_t>(number));
          emitted.push_back({i, number, parts_of(frame, number), frame.completion});
        }
      }
      CHECK(emitted.size() > 150);
      CHECK(emitted == expected(events));
      std::uint64_t joined = 0;
      for (const Emitted& frame : emitted) joined += frame.parts.size();
      CHECK(assembler.count(AssemblerEvent::datagrams_joined) == joined);
      CHECK(assembler.count(AssemblerEvent::restarts) == 0);
      CHECK(joined + assembler.count(AssemblerEvent::duplicate_datagrams) +
                assembler.count(AssemblerEvent::late_datagrams) ==
            arrivals);
    }
  }
}
