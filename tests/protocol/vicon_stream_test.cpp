#include "protocol/vicon_stream.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "tests/protocol/hex_bytes.hpp"

using namespace tissued::protocol;

namespace {

using Bytes = std::vector<std::uint8_t>;

// Frame 258 with two objects, written down from Vicon's layout. IEEE 754 float64: 1 = 3ff0.., -2 = c000.., 100 =
// 4059.., 0.5 = 3fe0.., -0.25 = bfd0...
const char* const kTwoObjects =
    "02 01 00 00  02"
    "  00  48 00  41 31 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
    "  00 00 00 00 00 00 f0 3f  00 00 00 00 00 00 00 c0  00 00 00 00 00 00 59 40"
    "  00 00 00 00 00 00 00 00  00 00 00 00 00 00 e0 3f  00 00 00 00 00 00 d0 bf"
    "  00  48 00  61 62 63 64 65 66 67 68 69 6a 6b 6c 6d 6e 6f 70 71 72 73 74 75 76 77 78"
    "  00 00 00 00 00 00 59 40  00 00 00 00 00 00 59 40  00 00 00 00 00 00 59 40"
    "  00 00 00 00 00 00 d0 bf  00 00 00 00 00 00 d0 bf  00 00 00 00 00 00 d0 bf";

// One item of each of our own kinds, and one of an id that nobody knows, with 2 bytes.
const char* const kOurItems =
    "07 00 00 00  05"
    "  54  0a 00  01 00 00 00 00 00 00 80  02 03"
    "  4d  31 00  4d 30 31 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
    "  00 00 00 00 00 00 f0 3f  00 00 00 00 00 00 00 c0  00 00 00 00 00 00 59 40  01"
    "  2a  02 00  ff ff"
    "  46  30 00  41 32 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
    "  00 00 00 00 00 00 e0 3f  00 00 00 00 00 00 d0 bf  00 00 00 00 00 00 00 00"
    "  58  30 00  54 31 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"
    "  00 00 00 00 00 00 59 40  00 00 00 00 00 00 f0 3f  00 00 00 00 00 00 00 c0";

constexpr std::size_t kItems = 5;  // offset of the first item

TrackerRefusal refusal_of(const Bytes& bytes) {
  TrackerDatagram datagram;
  return decode_tracker_datagram(bytes, datagram);
}

TrackerRefusal refusal_with(Bytes bytes, std::size_t offset, std::initializer_list<std::uint8_t> values) {
  std::copy(values.begin(), values.end(), bytes.begin() + static_cast<std::ptrdiff_t>(offset));
  return refusal_of(bytes);
}

bool in_limits(const std::array<double, 3>& values, double limit) {
  return std::all_of(values.begin(), values.end(), [=](double v) { return std::isfinite(v) && std::abs(v) <= limit; });
}

bool printable(const Name& name) {
  const auto text = name.view();
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c <= 0x7E; });
}

// What an accepted datagram promises, whatever came.
bool sound(const TrackerDatagram& datagram) {
  bool good = !datagram.stamp || datagram.stamp->part < datagram.stamp->part_count;
  for (const auto& object : datagram.objects) {
    good = good && printable(object.name) && in_limits(object.position, 1e5) && in_limits(object.rotation_rad, 10);
  }
  for (const auto& marker : datagram.markers) good = good && printable(marker.name) && in_limits(marker.position, 1e5);
  for (const auto& force : datagram.forces) good = good && printable(force.name) && in_limits(force.force, 1e5);
  for (const auto& truth : datagram.truth) good = good && printable(truth.name) && in_limits(truth.position, 1e5);
  return good;
}

}  // namespace

TEST_CASE("a datagram of Vicon Tracker is read") {
  TrackerDatagram datagram;
  REQUIRE(decode_tracker_datagram(bytes_of_hex(kTwoObjects), datagram) == TrackerRefusal::none);
  CHECK(datagram.frame_number == 258);
  CHECK_FALSE(datagram.stamp);
  CHECK(datagram.skipped_items == 0);
  CHECK(datagram.markers.empty());
  REQUIRE(datagram.objects.size() == 2);
  CHECK(datagram.objects[0].name.view() == "A1");
  CHECK(datagram.objects[0].position == std::array{1.0, -2.0, 100.0});
  CHECK(datagram.objects[0].rotation_rad == std::array{0.0, 0.5, -0.25});
  CHECK(datagram.objects[1].name.view() == "abcdefghijklmnopqrstuvwx");
  CHECK(datagram.objects[1].position == std::array{100.0, 100.0, 100.0});
  CHECK(datagram.objects[1].rotation_rad == std::array{-0.25, -0.25, -0.25});
}

TEST_CASE("our items are read, and an unknown one is passed over and counted") {
  TrackerDatagram datagram;
  REQUIRE(decode_tracker_datagram(bytes_of_hex(kOurItems), datagram) == TrackerRefusal::none);
  REQUIRE(datagram.stamp);
  CHECK(datagram.stamp->stamp_ns == 0x8000000000000001U);
  CHECK(datagram.stamp->part == 2);
  CHECK(datagram.stamp->part_count == 3);
  CHECK(datagram.skipped_items == 1);
  REQUIRE(datagram.markers.size() == 1);
  CHECK(datagram.markers[0].name.view() == "M01");
  CHECK(datagram.markers[0].position == std::array{1.0, -2.0, 100.0});
  CHECK(datagram.markers[0].occluded);
  REQUIRE(datagram.forces.size() == 1);
  CHECK(datagram.forces[0].name.view() == "A2");
  CHECK(datagram.forces[0].force == std::array{0.5, -0.25, 0.0});
  REQUIRE(datagram.truth.size() == 1);
  CHECK(datagram.truth[0].name.view() == "T1");
  CHECK(datagram.truth[0].position == std::array{100.0, 1.0, -2.0});
}

TEST_CASE("a datagram is decoded afresh whatever the struct held before") {
  TrackerDatagram datagram;
  REQUIRE(decode_tracker_datagram(bytes_of_hex(kOurItems), datagram) == TrackerRefusal::none);
  REQUIRE(decode_tracker_datagram(bytes_of_hex("09 00 00 00 00"), datagram) == TrackerRefusal::none);
  CHECK(datagram.frame_number == 9);
  CHECK_FALSE(datagram.stamp);
  CHECK(datagram.skipped_items == 0);
  CHECK(datagram.objects.size() + datagram.markers.size() + datagram.forces.size() + datagram.truth.size() == 0);
}

TEST_CASE("blocks padded with zeros to Tracker's sizes are read, other trailing bytes refused") {
  const Bytes exact = bytes_of_hex(kTwoObjects);
  for (const std::size_t size : {exact.size() + 1, std::size_t{256}, std::size_t{512}, std::size_t{1024}}) {
    Bytes padded = exact;
    padded.resize(size);
    CHECK(refusal_of(padded) == TrackerRefusal::none);
    padded.back() = 1;
    CHECK(refusal_of(padded) == TrackerRefusal::trailing_bytes);
  }
  Bytes too_long = exact;
  too_long.resize(1025);
  CHECK(refusal_of(too_long) == TrackerRefusal::too_long);
  CHECK(refusal_with(exact, 4, {1}) == TrackerRefusal::trailing_bytes);  // one item fewer announced than there are
}

TEST_CASE("each gate of the tracker stream refuses by its name") {
  const Bytes objects = bytes_of_hex(kTwoObjects);
  const Bytes ours = bytes_of_hex(kOurItems);
  const std::size_t name = kItems + 3, position = name + 24, rotation = position + 24;
  const std::size_t stamp = kItems + 3, marker = kItems + 13 + 3;
  const std::uint8_t nan_high[] = {0xF8, 0x7F}, infinity_high[] = {0xF0, 0xFF};
  SECTION("too short") {
    CHECK(refusal_of({}) == TrackerRefusal::too_short);
    CHECK(refusal_of({1, 2, 3, 4}) == TrackerRefusal::too_short);
  }
  SECTION("truncated item") {
    CHECK(refusal_with(objects, 4, {3}) == TrackerRefusal::truncated_item);
    CHECK(refusal_with(ours, ours.size() - 50, {0xFF, 0xFF}) == TrackerRefusal::truncated_item);
  }
  SECTION("wrong item size") {
    CHECK(refusal_with(objects, kItems + 1, {71}) == TrackerRefusal::wrong_item_size);
    CHECK(refusal_with(ours, kItems + 1, {9}) == TrackerRefusal::wrong_item_size);
    CHECK(refusal_with(ours, marker - 2, {48}) == TrackerRefusal::wrong_item_size);
    CHECK(refusal_with(objects, kItems, {0x4D}) == TrackerRefusal::wrong_item_size);  // a marker of 72 bytes
  }
  SECTION("bad name") {
    CHECK(refusal_with(objects, name, {0}) == TrackerRefusal::bad_name);
    CHECK(refusal_with(objects, name, {0, 0}) == TrackerRefusal::bad_name);
    CHECK(refusal_with(objects, name + 1, {0x07}) == TrackerRefusal::bad_name);
    CHECK(refusal_with(objects, name + 1, {0xC3}) == TrackerRefusal::bad_name);
    CHECK(refusal_with(objects, name + 23, {'x'}) == TrackerRefusal::bad_name);
  }
  SECTION("bad flags") { CHECK(refusal_with(ours, marker + 48, {0x02}) == TrackerRefusal::bad_flags); }
  SECTION("bad stamp") {
    CHECK(refusal_with(ours, stamp + 8, {3, 3}) == TrackerRefusal::bad_stamp);
    CHECK(refusal_with(ours, stamp + 8, {0, 0}) == TrackerRefusal::bad_stamp);
  }
  SECTION("repeated stamp") {
    Bytes twice = ours;
    twice.insert(twice.begin() + kItems, ours.begin() + kItems, ours.begin() + kItems + 13);
    twice[4] = 6;
    CHECK(refusal_of(twice) == TrackerRefusal::repeated_stamp);
  }
  SECTION("not finite") {
    for (const std::size_t field : {position, position + 16, rotation, rotation + 16}) {
      CHECK(refusal_with(objects, field + 6, {nan_high[0], nan_high[1]}) == TrackerRefusal::not_finite);
      CHECK(refusal_with(objects, field + 6, {infinity_high[0], infinity_high[1]}) == TrackerRefusal::not_finite);
    }
    CHECK(refusal_with(ours, marker + 24 + 6, {nan_high[0], nan_high[1]}) == TrackerRefusal::not_finite);
  }
  SECTION("absurd magnitude") {
    // 1e5 = 40f86a0000000000; the next number up is refused. 10 = 4024000000000000.
    CHECK(refusal_with(objects, position, {0, 0, 0, 0, 0, 0x6A, 0xF8, 0x40}) == TrackerRefusal::none);
    CHECK(refusal_with(objects, position, {1, 0, 0, 0, 0, 0x6A, 0xF8, 0xC0}) == TrackerRefusal::absurd_magnitude);
    CHECK(refusal_with(objects, rotation, {0, 0, 0, 0, 0, 0, 0x24, 0xC0}) == TrackerRefusal::none);
    CHECK(refusal_with(objects, rotation, {1, 0, 0, 0, 0, 0, 0x24, 0x40}) == TrackerRefusal::absurd_magnitude);
    CHECK(refusal_with(ours, ours.size() - 8, {0, 0, 0, 0, 0, 0, 0, 0x7F}) == TrackerRefusal::absurd_magnitude);
    CHECK(refusal_with(ours, ours.size() - 51 - 8, {0, 0, 0, 0, 0, 0, 0, 0x7F}) == TrackerRefusal::absurd_magnitude);
  }
}

TEST_CASE("every truncation of a tracker datagram is refused") {
  for (const char* golden : {kTwoObjects, kOurItems}) {
    const Bytes whole = bytes_of_hex(golden);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      CHECK(refusal_of(part) == (size < 5 ? TrackerRefusal::too_short : TrackerRefusal::truncated_item));
    }
  }
}

TEST_CASE("every corrupted byte of a tracker datagram is refused or harmless") {
  for (const char* golden : {kTwoObjects, kOurItems}) {
    const Bytes whole = bytes_of_hex(golden);
    bool all_sound = true;
    std::size_t refused = 0;
    for (std::size_t offset = 0; offset < whole.size(); ++offset) {
      for (int value = 0; value < 256; ++value) {
        Bytes corrupted = whole;
        corrupted[offset] = static_cast<std::uint8_t>(value);
        TrackerDatagram datagram;
        const bool accepted = decode_tracker_datagram(corrupted, datagram) == TrackerRefusal::none;
        all_sound = all_sound && (!accepted || sound(datagram));
        refused += accepted ? 0 : 1;
      }
    }
    CHECK(all_sound);
    CHECK(refused > 0);
  }
}

TEST_CASE("every corrupted size, padding or flag byte of an item is refused by its name") {
  const Bytes ours = bytes_of_hex(kOurItems);
  const std::size_t marker = kItems + 13;
  for (int value = 0; value < 256; ++value) {
    const auto byte = static_cast<std::uint8_t>(value);
    for (const std::size_t size_byte : {marker + 1, marker + 2}) {
      if (byte == ours[size_byte]) continue;
      const TrackerRefusal refusal = refusal_with(ours, size_byte, {byte});
      CHECK((refusal == TrackerRefusal::wrong_item_size || refusal == TrackerRefusal::truncated_item));
    }
    for (std::size_t padding = marker + 3 + 4; padding < marker + 3 + 24; ++padding) {
      CHECK(refusal_with(ours, padding, {byte}) == (byte == 0 ? TrackerRefusal::none : TrackerRefusal::bad_name));
    }
    CHECK(refusal_with(ours, marker + 3 + 48, {byte}) ==
          (byte <= 1 ? TrackerRefusal::none : TrackerRefusal::bad_flags));
  }
}

TEST_CASE("refusals have distinct names") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kTrackerRefusalCount; ++i) names.insert(to_string(static_cast<TrackerRefusal>(i)));
  CHECK(names.size() == kTrackerRefusalCount);
  CHECK(names.count("unknown") == 0);
  CHECK(std::string(to_string(static_cast<TrackerRefusal>(kTrackerRefusalCount))) == "unknown");
}
