#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "protocol/vicon_stream.hpp"
#include "tests/protocol/hex_bytes.hpp"

using namespace tissued::protocol;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Name name(const std::string& text) { return Name::from(text).value(); }

Name name(std::string text, int number) { return name(text.append(std::to_string(number))); }

TrackerFrame readme_frame() {
  TrackerFrame frame;
  frame.frame_number = 1000;
  frame.stamp_ns = 2'500'000'000;
  frame.objects.push_back({name("A1"), {53.5, 0, 35.75}, {0, 0, 1.5}});
  frame.markers.push_back({name("M01"), {0, -0.5, 60}, false});
  return frame;
}

TrackerFrame full_frame() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> position(-1e5, 1e5), angle(-10, 10);
  const auto point = [&] { return std::array{position(random), position(random), position(random)}; };
  TrackerFrame frame;
  frame.frame_number = 0xFFFFFFFF;
  frame.stamp_ns = 12345;
  for (int i = 0; i < 32; ++i) {
    frame.objects.push_back({name("A", i), point(), {angle(random), angle(random), angle(random)}});
    frame.forces.push_back({name("A", i), point()});
  }
  for (int i = 0; i < 128; ++i) frame.markers.push_back({name("M", i), point(), false});
  for (int i = 0; i < 64; ++i) frame.truth.push_back({name("T", i), point()});
  return frame;
}

// All items of the packets in order, and how many of the packets were refused.
struct Joined {
  std::vector<TrackedObject> objects;
  std::vector<TrackedMarker> markers;
  std::vector<PadForce> forces;
  std::vector<TargetTruth> truth;
  std::vector<FrameStamp> stamps;
};

Joined decode_all(std::span<const TrackerPacket> packets, std::uint32_t frame_number) {
  Joined joined;
  for (const TrackerPacket& packet : packets) {
    TrackerDatagram datagram;
    REQUIRE(decode_tracker_datagram(packet.view(), datagram) == TrackerRefusal::none);
    REQUIRE(datagram.frame_number == frame_number);
    joined.objects.insert(joined.objects.end(), datagram.objects.begin(), datagram.objects.end());
    joined.markers.insert(joined.markers.end(), datagram.markers.begin(), datagram.markers.end());
    joined.forces.insert(joined.forces.end(), datagram.forces.begin(), datagram.forces.end());
    joined.truth.insert(joined.truth.end(), datagram.truth.begin(), datagram.truth.end());
    if (datagram.stamp) joined.stamps.push_back(*datagram.stamp);
  }
  return joined;
}

}  // namespace

TEST_CASE("the README's tracker datagram is what we send and read") {
  const auto golden = bytes_of_readme("tracker");
  std::vector<TrackerPacket> packets(2);
  REQUIRE(encode_tracker_frame(readme_frame(), packets) == 1);
  const auto sent = packets[0].view();
  CHECK(std::vector(sent.begin(), sent.end()) == golden);
  TrackerDatagram datagram;
  REQUIRE(decode_tracker_datagram(golden, datagram) == TrackerRefusal::none);
  CHECK(datagram.frame_number == 1000);
  CHECK(datagram.stamp->stamp_ns == 2'500'000'000);
  CHECK(datagram.objects[0].position == std::array{53.5, 0.0, 35.75});
  CHECK(datagram.objects[0].rotation_rad == std::array{0.0, 0.0, 1.5});
  CHECK(datagram.markers[0].position == std::array{0.0, -0.5, 60.0});
}

TEST_CASE("a full frame goes out in numbered parts and comes back whole") {
  const TrackerFrame frame = full_frame();
  std::vector<TrackerPacket> packets(kMaxPacketsPerFrame);
  const std::size_t count = encode_tracker_frame(frame, packets);
  REQUIRE(count > 1);
  const Joined joined = decode_all(std::span(packets).first(count), 0xFFFFFFFF);
  REQUIRE(joined.stamps.size() == count);
  for (std::size_t part = 0; part < count; ++part) {
    CHECK(joined.stamps[part].stamp_ns == 12345);
    CHECK(joined.stamps[part].part == part);
    CHECK(joined.stamps[part].part_count == count);
  }
  REQUIRE(joined.objects.size() == 32);
  REQUIRE(joined.markers.size() == 128);
  REQUIRE(joined.forces.size() == 32);
  REQUIRE(joined.truth.size() == 64);
  for (std::size_t i = 0; i < 32; ++i) {
    CHECK(joined.objects[i].name == frame.objects[i].name);
    CHECK(joined.objects[i].position == frame.objects[i].position);
    CHECK(joined.objects[i].rotation_rad == frame.objects[i].rotation_rad);
    CHECK(joined.forces[i].name == frame.forces[i].name);
    CHECK(joined.forces[i].force == frame.forces[i].force);
  }
  for (std::size_t i = 0; i < 128; ++i) CHECK(joined.markers[i].position == frame.markers[i].position);
  for (std::size_t i = 0; i < 64; ++i) CHECK(joined.truth[i].position == frame.truth[i].position);
}

TEST_CASE("19 markers and their stamp fill one datagram, and a frame without a stamp is plain Vicon") {
  TrackerFrame frame;
  for (int i = 0; i < 19; ++i) frame.markers.push_back({name("M", i), {1, 2, 3}, false});
  frame.stamp_ns = 1;
  std::vector<TrackerPacket> packets(kMaxPacketsPerFrame);
  CHECK(encode_tracker_frame(frame, packets) == 1);
  CHECK(packets[0].size == 5 + 13 + 19 * 52);
  frame.stamp_ns.reset();
  frame.markers.clear();
  for (int i = 0; i < 14; ++i) frame.objects.push_back({name("O", i), {1, 2, 3}, {}});
  REQUIRE(encode_tracker_frame(frame, packets) == 2);
  CHECK(packets[0].size == 5 + 13 * 75);
  CHECK(packets[1].size == 5 + 75);
  CHECK(decode_all(std::span(packets).first(2), 0).stamps.empty());
}

TEST_CASE("an empty frame is one datagram without items") {
  std::vector<TrackerPacket> packets(1);
  REQUIRE(encode_tracker_frame({}, packets) == 1);
  CHECK(packets[0].size == 5);
}

TEST_CASE("nothing of an occluded marker's position goes out") {
  TrackerFrame frame;
  frame.markers.push_back({name("M01"), {kNan, 1e9, 3}, true});
  std::vector<TrackerPacket> packets(1);
  REQUIRE(encode_tracker_frame(frame, packets) == 1);
  const Joined joined = decode_all(packets, 0);
  CHECK(joined.markers[0].occluded);
  CHECK(joined.markers[0].position == std::array{0.0, 0.0, 0.0});
}

TEST_CASE("a frame that a receiver would refuse, or that needs more packets, is not encoded") {
  TrackerFrame frame = full_frame();
  std::vector<TrackerPacket> packets(kMaxPacketsPerFrame);
  const std::size_t needed = encode_tracker_frame(frame, packets);
  REQUIRE(needed > 0);
  CHECK(encode_tracker_frame(frame, std::span(packets).first(needed - 1)) == 0);
  CHECK(encode_tracker_frame(frame, std::span(packets).first(0)) == 0);
  SECTION("object position") { frame.objects[3].position[1] = kNan; }
  SECTION("object rotation") { frame.objects[3].rotation_rad[1] = 10.5; }
  SECTION("marker") { frame.markers[127].position[2] = 1.1e5; }
  SECTION("force") { frame.forces[0].force[0] = std::numeric_limits<double>::infinity(); }
  SECTION("truth") { frame.truth[63].position[0] = kNan; }
  SECTION("name") { frame.truth[5].name = Name(); }
  CHECK(encode_tracker_frame(frame, packets) == 0);
}
