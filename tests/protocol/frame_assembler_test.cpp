#include "protocol/frame_assembler.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

using namespace tissued::protocol;

namespace {

constexpr std::uint64_t kMs = 1'000'000;

Name name(const std::string& text) { return Name::from(text).value(); }

Name name(std::string text, int number) { return name(text.append(std::to_string(number))); }

TrackerDatagram plain(std::uint32_t frame, const std::vector<std::string>& objects) {
  TrackerDatagram datagram;
  datagram.frame_number = frame;
  for (const auto& object : objects) datagram.objects.push_back({name(object), {1.0 * frame, 2, 3}, {}});
  return datagram;
}

// Part `part` of `parts`, with one marker named after the part.
TrackerDatagram stamped(std::uint32_t frame, std::uint8_t part = 0, std::uint8_t parts = 1) {
  TrackerDatagram datagram;
  datagram.frame_number = frame;
  datagram.stamp = FrameStamp{frame * 10 * kMs, part, parts};
  datagram.markers.push_back({name("M", part), {1.0 * frame, 1.0 * part, 0}, false});
  return datagram;
}

// Feeds datagrams a millisecond apart and notes which frames come out.
class Stream {
 public:
  explicit Stream(FrameAssemblerConfig config = {}) : assembler(std::move(config)) {}

  std::vector<std::uint32_t> add(const TrackerDatagram& datagram, std::uint64_t wait_ns = kMs) {
    now_ns += wait_ns;
    return note(assembler.add(datagram, now_ns));
  }

  std::vector<std::uint32_t> flush(std::uint64_t wait_ns) {
    now_ns += wait_ns;
    return note(assembler.flush_if_due(now_ns));
  }

  std::uint64_t count(AssemblerEvent event) const { return assembler.count(event); }

  FrameAssembler assembler;
  TrackerFrame last;
  std::uint64_t now_ns = 5000 * kMs;

 private:
  std::vector<std::uint32_t> note(std::span<const TrackerFrame> frames) {
    std::vector<std::uint32_t> numbers;
    for (const TrackerFrame& frame : frames) {
      numbers.push_back(frame.frame_number);
      last = frame;
    }
    return numbers;
  }
};

using Numbers = std::vector<std::uint32_t>;

}  // namespace

TEST_CASE("a frame of one datagram comes out at once") {
  Stream stream;
  CHECK(stream.add(stamped(7)) == Numbers{7});
  CHECK(stream.last.stamp_ns == 70 * kMs);
  CHECK(stream.last.receive_ns == stream.now_ns);
  CHECK(stream.last.completion == FrameCompletion::all_parts);
  CHECK_FALSE(stream.last.after_restart);
  REQUIRE(stream.last.markers.size() == 1);
  CHECK(stream.last.markers[0].position == std::array{7.0, 0.0, 0.0});
  CHECK_FALSE(stream.assembler.due_ns());
}

TEST_CASE("a frame of three datagrams waits for all of them, in whatever order") {
  for (const auto& order : {std::vector{0, 1, 2}, {2, 1, 0}, {1, 2, 0}}) {
    Stream stream;
    CHECK(stream.add(stamped(7, static_cast<std::uint8_t>(order[0]), 3)).empty());
    const std::uint64_t first_ns = stream.now_ns;
    CHECK(stream.add(stamped(7, static_cast<std::uint8_t>(order[1]), 3)).empty());
    CHECK(stream.add(stamped(7, static_cast<std::uint8_t>(order[2]), 3)) == Numbers{7});
    CHECK(stream.last.receive_ns == first_ns);
    CHECK(stream.last.markers.size() == 3);
    CHECK(stream.count(AssemblerEvent::datagrams_joined) == 3);
    CHECK(stream.count(AssemblerEvent::frames_all_parts) == 1);
  }
}

TEST_CASE("without stamps a frame waits for every expected name") {
  Stream stream({.markers = {name("M1"), name("M2")}, .objects = {name("A1")}});
  CHECK(stream.add(plain(1, {"M1"})).empty());
  CHECK(stream.add(plain(1, {"A1", "probe"})).empty());
  CHECK(stream.add(plain(1, {"M2"})) == Numbers{1});
  CHECK(stream.last.completion == FrameCompletion::all_names);
  CHECK_FALSE(stream.last.stamp_ns);
  // Labelled markers that came as Vicon objects are markers.
  REQUIRE(stream.last.markers.size() == 2);
  CHECK(stream.last.markers[0].name.view() == "M1");
  CHECK(stream.last.markers[0].position == std::array{1.0, 2.0, 3.0});
  CHECK_FALSE(stream.last.markers[0].occluded);
  CHECK(stream.last.objects.size() == 2);
}

TEST_CASE("every frame waits for the names anew") {
  for (const auto& order : {std::vector<std::string>{"M1", "A1"}, {"A1", "M1"}}) {
    Stream stream({.markers = {name("M1")}, .objects = {name("A1")}});
    for (std::uint32_t frame = 1; frame < 4; ++frame) {
      CHECK(stream.add(plain(frame, {order[0]})).empty());
      CHECK(stream.add(plain(frame, {order[1]})) == Numbers{frame});
    }
  }
}

TEST_CASE("forces and truth are handed on with the frame that they came with") {
  Stream stream;
  for (std::uint32_t frame = 1; frame < 4; ++frame) {
    TrackerDatagram first = stamped(frame, 0, 2), second = stamped(frame, 1, 2);
    first.forces.push_back({name("A1"), {1.0 * frame, 0, 0}});
    second.forces.push_back({name("A2"), {2.0 * frame, 0, 0}});
    second.truth.push_back({name("T1"), {3.0 * frame, 0, 0}});
    CHECK(stream.add(first).empty());
    CHECK(stream.add(second) == Numbers{frame});
    REQUIRE(stream.last.forces.size() == 2);
    CHECK(stream.last.forces[0].force[0] == frame);
    CHECK(stream.last.forces[1].force[0] == 2 * frame);
    REQUIRE(stream.last.truth.size() == 1);
    CHECK(stream.last.truth[0].position[0] == 3 * frame);
  }
  CHECK(stream.count(AssemblerEvent::duplicate_items) == 0);
}

TEST_CASE("without stamps a new force or truth makes a datagram no duplicate") {
  Stream stream;
  TrackerDatagram datagram = plain(1, {"A1"});
  stream.add(datagram);
  datagram.forces.push_back({name("A1"), {1, 0, 0}});
  stream.add(datagram);
  datagram.truth.push_back({name("T1"), {1, 0, 0}});
  stream.add(datagram);
  CHECK(stream.count(AssemblerEvent::duplicate_datagrams) == 0);
  stream.add(datagram);
  CHECK(stream.count(AssemblerEvent::duplicate_datagrams) == 1);
  CHECK(stream.count(AssemblerEvent::duplicate_items) == 3);
  CHECK(stream.flush(10 * kMs) == Numbers{1});
  CHECK(stream.last.forces.size() == 1);
  CHECK(stream.last.truth.size() == 1);
}

TEST_CASE("a frame that nobody flushed still takes its parts, however late") {
  Stream stream({.restart_silence_ns = 500 * kMs});
  stream.add(stamped(1, 0, 2));
  CHECK(stream.add(stamped(1, 1, 2), 2000 * kMs) == Numbers{1});
  CHECK_FALSE(stream.last.after_restart);
  CHECK(stream.last.markers.size() == 2);
}

TEST_CASE("an occluded marker was seen to be sent") {
  Stream stream({.markers = {name("M0"), name("M1")}});
  TrackerDatagram datagram;
  datagram.markers.push_back({name("M0"), {}, true});
  datagram.markers.push_back({name("M1"), {}, false});
  CHECK(stream.add(datagram) == Numbers{0});
  CHECK(stream.last.markers[0].occluded);
}

TEST_CASE("all parts do not stand in for an object that every frame must carry") {
  Stream stream({.objects = {name("A1")}});
  CHECK(stream.add(stamped(1)).empty());
  CHECK(stream.add(plain(1, {"A1"})) == Numbers{1});
  CHECK(stream.last.completion == FrameCompletion::all_parts);
  CHECK(stream.last.stamp_ns == 10 * kMs);
}

TEST_CASE("with neither stamps nor expected names a frame ends with the next, or with its deadline") {
  Stream stream;
  CHECK(stream.add(plain(1, {"A1"})).empty());
  CHECK(stream.add(plain(1, {"A2"})).empty());
  CHECK(stream.add(plain(2, {"A1"})) == Numbers{1});
  CHECK(stream.last.completion == FrameCompletion::superseded);
  CHECK(stream.last.objects.size() == 2);
  CHECK(stream.flush(4 * kMs) == Numbers{2});
  CHECK(stream.last.completion == FrameCompletion::deadline);
}

TEST_CASE("a frame that lost a part comes out when a newer one begins, both from one datagram") {
  Stream stream;
  CHECK(stream.add(stamped(1, 0, 2)).empty());
  CHECK(stream.add(stamped(2)) == Numbers{1, 2});
  CHECK(stream.count(AssemblerEvent::frames_superseded) == 1);
  CHECK(stream.count(AssemblerEvent::frames_all_parts) == 1);
  CHECK(stream.add(stamped(1, 1, 2)).empty());
  CHECK(stream.count(AssemblerEvent::late_datagrams) == 1);
}

TEST_CASE("markers of a late datagram go along with the next frame, those of the newest late frame") {
  Stream stream({.markers = {name("C7")}});
  const auto pads = [](std::uint32_t frame) {
    TrackerDatagram datagram = plain(frame, {"A1"});
    datagram.stamp = FrameStamp{frame * 10 * kMs, 0, 1};
    return datagram;
  };
  CHECK(stream.add(pads(20)) == Numbers{20});
  CHECK(stream.last.late.markers.empty());
  CHECK(stream.add(stamped(10, 0, 2)).empty());
  CHECK(stream.add(stamped(12, 0, 2)).empty());
  CHECK(stream.add(stamped(11, 0, 2)).empty());  // older than what waits already
  TrackerDatagram second = stamped(12, 1, 2);
  second.objects.push_back({name("C7"), {7, 7, 7}, {}});  // a marker of the config, sent as an object
  CHECK(stream.add(second).empty());
  CHECK(stream.add(stamped(12, 1, 2)).empty());  // a copy
  CHECK(stream.count(AssemblerEvent::late_datagrams) == 5);
  CHECK(stream.add(pads(21)) == Numbers{21});
  const LateMarkers& late = stream.last.late;
  CHECK(late.frame_number == 12);
  CHECK(late.stamp_ns == 120 * kMs);
  REQUIRE(late.markers.size() == 3);
  CHECK(late.markers[0].position == std::array<double, 3>{12, 0, 0});
  CHECK(late.markers[1].position == std::array<double, 3>{12, 1, 0});
  CHECK(late.markers[2].name == name("C7"));
  CHECK(stream.add(pads(22)) == Numbers{22});
  CHECK(stream.last.late.markers.empty());  // they went along once
}

TEST_CASE("the deadline counts from the first datagram and passes to the nanosecond") {
  Stream stream({.deadline_ns = 4 * kMs});
  CHECK(stream.flush(kMs).empty());
  stream.add(stamped(1, 0, 3));
  const std::uint64_t first_ns = stream.now_ns;
  stream.add(stamped(1, 1, 3), kMs);
  CHECK(stream.assembler.due_ns() == first_ns + 4 * kMs);
  CHECK(stream.flush(3 * kMs - 1).empty());
  CHECK(stream.flush(1) == Numbers{1});
  CHECK(stream.last.markers.size() == 2);
  CHECK(stream.flush(kMs).empty());
  CHECK(stream.add(stamped(1, 2, 3)).empty());
  CHECK(stream.count(AssemblerEvent::late_datagrams) == 1);
  CHECK(stream.count(AssemblerEvent::frames_deadline) == 1);
}

TEST_CASE("duplicates are dropped while a frame is open, and after") {
  Stream stream({.markers = {name("M1"), name("M2")}});
  SECTION("stamped") {
    CHECK(stream.add(stamped(1, 0, 2)).empty());
    CHECK(stream.add(stamped(1, 0, 2)).empty());
    CHECK(stream.add(stamped(1, 1, 2)) == Numbers{1});
    CHECK(stream.add(stamped(1, 0, 2)).empty());
  }
  SECTION("plain") {
    CHECK(stream.add(plain(1, {"M1", "probe"})).empty());
    CHECK(stream.add(plain(1, {"M1", "probe"})).empty());
    CHECK(stream.add(plain(1, {"M2"})) == Numbers{1});
    CHECK(stream.add(plain(1, {"M2"})).empty());
  }
  CHECK(stream.count(AssemblerEvent::duplicate_datagrams) == 2);
  CHECK(stream.count(AssemblerEvent::duplicate_items) == 0);
  CHECK(stream.count(AssemblerEvent::late_datagrams) == 0);
}

TEST_CASE("of a name that comes twice in a frame the first stays") {
  Stream stream;
  TrackerDatagram datagram = stamped(1);
  datagram.markers.push_back({name("M0"), {9, 9, 9}, false});
  CHECK(stream.add(datagram) == Numbers{1});
  REQUIRE(stream.last.markers.size() == 1);
  CHECK(stream.last.markers[0].position == std::array{1.0, 0.0, 0.0});
  CHECK(stream.count(AssemblerEvent::duplicate_items) == 1);
}

TEST_CASE("a part that contradicts the other parts of its frame is dropped") {
  Stream stream;
  stream.add(stamped(1, 0, 2));
  stream.add(stamped(1, 1, 3));
  TrackerDatagram other_time = stamped(1, 1, 2);
  other_time.stamp->stamp_ns += 1;
  stream.add(other_time);
  CHECK(stream.count(AssemblerEvent::inconsistent_datagrams) == 2);
  CHECK(stream.add(stamped(1, 1, 2)) == Numbers{1});
}

TEST_CASE("more items than a frame holds are counted and dropped") {
  Stream stream;
  for (std::uint8_t part = 0; part < 4; ++part) {
    TrackerDatagram datagram;
    datagram.stamp = FrameStamp{0, part, 4};
    for (int i = 0; i < 10; ++i) datagram.forces.push_back({name("A", 10 * part + i), {}});
    stream.add(datagram);
  }
  CHECK(stream.last.forces.size() == 32);
  CHECK(stream.count(AssemblerEvent::overflowing_items) == 8);
}

TEST_CASE("frames passed over are counted, a long gap as one jump") {
  Stream stream;
  stream.add(stamped(1));
  CHECK(stream.add(stamped(4)) == Numbers{4});
  CHECK(stream.count(AssemblerEvent::frames_missing) == 2);
  CHECK(stream.add(stamped(4 + 65)) == Numbers{69});
  CHECK(stream.count(AssemblerEvent::frames_missing) == 2 + 64);
  CHECK(stream.add(stamped(69 + 66)).empty());
  CHECK(stream.add(stamped(69 + 67)) == Numbers{136});
  CHECK(stream.count(AssemblerEvent::frames_missing) == 2 + 64);
  CHECK(stream.count(AssemblerEvent::forward_jumps) == 1);
}

TEST_CASE("one stray datagram from far ahead is not followed, however often it comes") {
  Stream stream;
  stream.add(stamped(1000));
  for (std::uint32_t i = 0; i < 5; ++i) {
    CHECK(stream.add(stamped(50000)).empty());
    CHECK(stream.add(stamped(50000)).empty());
    CHECK(stream.add(stamped(1001 + i)) == Numbers{1001 + i});
    CHECK(stream.add(stamped(50001)).empty());  // the stream went on in between
    CHECK(stream.add(stamped(40000)).empty());  // descending
  }
  CHECK(stream.count(AssemblerEvent::jump_suspects) == 20);
  CHECK(stream.count(AssemblerEvent::forward_jumps) == 0);
}

TEST_CASE("wrap-around of the frame number is a step like any other") {
  Stream stream;
  stream.add(stamped(0xFFFFFFFD));
  stream.add(stamped(0xFFFFFFFF, 0, 2));
  CHECK(stream.add(stamped(1, 0, 2)) == Numbers{0xFFFFFFFF});
  CHECK(stream.add(stamped(0xFFFFFFFF, 1, 2)).empty());
  CHECK(stream.add(stamped(1, 1, 2)) == Numbers{1});
  CHECK_FALSE(stream.last.after_restart);
  CHECK(stream.count(AssemblerEvent::frames_missing) == 2);
  CHECK(stream.count(AssemblerEvent::late_datagrams) == 1);
  CHECK(stream.count(AssemblerEvent::restarts) == 0);
}

TEST_CASE("a reordered frame is late, not a restart") {
  Stream stream;
  stream.add(stamped(100));
  stream.add(stamped(104));
  for (const std::uint32_t frame : {101U, 102U, 103U}) CHECK(stream.add(stamped(frame)).empty());
  CHECK(stream.add(stamped(105)) == Numbers{105});
  CHECK(stream.count(AssemblerEvent::late_datagrams) == 3);
  CHECK(stream.count(AssemblerEvent::restarts) == 0);
}

TEST_CASE("one stray datagram from far behind is not a restart, however often it comes") {
  Stream stream;
  stream.add(stamped(1000));
  for (std::uint32_t i = 0; i < 5; ++i) {
    CHECK(stream.add(stamped(10)).empty());
    CHECK(stream.add(stamped(10)).empty());
    CHECK(stream.add(stamped(1001 + i)) == Numbers{1001 + i});
  }
  CHECK(stream.count(AssemblerEvent::restart_suspects) == 10);
  CHECK(stream.count(AssemblerEvent::restarts) == 0);
}

TEST_CASE("64 frames behind is late, 65 are suspect") {
  Stream stream;
  stream.add(stamped(1000));
  stream.add(stamped(936));
  CHECK(stream.count(AssemblerEvent::late_datagrams) == 1);
  CHECK(stream.count(AssemblerEvent::restart_suspects) == 0);
  stream.add(stamped(935));
  CHECK(stream.count(AssemblerEvent::late_datagrams) == 1);
  CHECK(stream.count(AssemblerEvent::restart_suspects) == 1);
}

TEST_CASE("a tracker that restarts far behind is followed with its second frame") {
  Stream stream;
  stream.add(stamped(1000, 0, 2));
  CHECK(stream.add(stamped(0, 0, 2)).empty());
  CHECK(stream.add(stamped(0, 1, 2)).empty());
  CHECK(stream.add(stamped(1, 0, 2)) == Numbers{1000});
  CHECK(stream.add(stamped(1, 1, 2)) == Numbers{1});
  CHECK(stream.last.after_restart);
  CHECK(stream.add(stamped(2)) == Numbers{2});
  CHECK_FALSE(stream.last.after_restart);
  CHECK(stream.count(AssemblerEvent::restarts) == 1);
  CHECK(stream.count(AssemblerEvent::restart_suspects) == 2);
}

TEST_CASE("two strays from far behind in descending order confirm nothing") {
  Stream stream;
  stream.add(stamped(1000));
  CHECK(stream.add(stamped(10)).empty());
  CHECK(stream.add(stamped(9)).empty());
  CHECK(stream.add(stamped(500)).empty());  // ascending, but no tracker skips so far
  CHECK(stream.add(stamped(1001)) == Numbers{1001});
  CHECK(stream.count(AssemblerEvent::restarts) == 0);
}

TEST_CASE("a tracker that restarts a little behind is followed with the eighth ascending frame") {
  Stream stream;
  stream.add(stamped(40));
  for (std::uint32_t frame = 0; frame < 7; ++frame) CHECK(stream.add(stamped(frame)).empty());
  CHECK(stream.add(stamped(7)) == Numbers{7});
  CHECK(stream.last.after_restart);
  CHECK(stream.add(stamped(8)) == Numbers{8});
  CHECK(stream.count(AssemblerEvent::late_datagrams) == 7);
  CHECK(stream.count(AssemblerEvent::restarts) == 1);
}

TEST_CASE("late frames that newer ones interrupt never add up to a restart") {
  Stream stream;
  stream.add(stamped(100));
  for (std::uint32_t i = 1; i < 30; ++i) {
    CHECK(stream.add(stamped(100 + 2 * i)) == Numbers{100 + 2 * i});
    CHECK(stream.add(stamped(99 + 2 * i)).empty());
  }
  CHECK(stream.count(AssemblerEvent::restarts) == 0);
}

TEST_CASE("after a silence any frame number is followed at once") {
  for (const std::uint32_t frame : {100U, 99U, 0U}) {
    Stream stream({.restart_silence_ns = 500 * kMs});
    stream.add(stamped(100));
    CHECK(stream.add(stamped(frame), 500 * kMs - 1).empty());
    CHECK(stream.add(stamped(frame), 1) == Numbers{frame});
    CHECK(stream.last.after_restart);
    CHECK(stream.count(AssemblerEvent::restarts) == 1);
  }
  Stream stream;
  stream.add(stamped(100));
  CHECK(stream.add(stamped(101), 900 * kMs) == Numbers{101});
  CHECK_FALSE(stream.last.after_restart);
}

TEST_CASE("late datagrams do not keep a silent stream alive") {
  Stream stream({.late_frames_for_restart = 1000, .restart_silence_ns = 500 * kMs});
  stream.add(stamped(100));
  std::uint32_t frame = 50;
  while (stream.add(stamped(frame), 10 * kMs).empty()) ++frame;
  CHECK(frame == 50 + 49);
  CHECK(stream.last.after_restart);
}

TEST_CASE("events and completions have distinct names") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kAssemblerEventCount; ++i) names.insert(to_string(static_cast<AssemblerEvent>(i)));
  CHECK(names.size() == kAssemblerEventCount);
  CHECK(names.count("unknown") == 0);
  for (const auto completion : {FrameCompletion::all_parts, FrameCompletion::all_names, FrameCompletion::superseded,
                                FrameCompletion::deadline}) {
    CHECK(names.count(std::string("frames_") + to_string(completion)) == 1);
  }
}
