#include "daemon/unreliable_channel.hpp"

#include <catch2/catch.hpp>
#include <map>

using namespace tissued;
using namespace tissued::daemon;

namespace {

constexpr std::uint64_t kPeriod_ns = 10'000'000;

protocol::TrackerPacket packet_number(std::uint8_t low, std::uint8_t high) {
  protocol::TrackerPacket packet;
  packet.bytes[0] = low;
  packet.bytes[1] = high;
  packet.size = 2;
  return packet;
}

struct Arrival {
  int number;
  std::uint64_t time_ns;
  bool operator==(const Arrival&) const = default;
};

// Sends `count` datagrams, one every 10 ms, and lists what arrives.
std::vector<Arrival> send_through(UnreliableChannel& channel, int count) {
  std::vector<Arrival> arrivals;
  const auto drain = [&](std::uint64_t until_ns) {
    while (channel.due_ns() && *channel.due_ns() <= until_ns) {
      const std::uint64_t time = *channel.due_ns();
      const auto packet = channel.receive();
      arrivals.push_back({packet.bytes[0] + 256 * packet.bytes[1], time});
    }
  };
  for (int i = 0; i < count; ++i) {
    const std::uint64_t now = std::uint64_t(i) * kPeriod_ns;
    drain(now);
    channel.send(packet_number(std::uint8_t(i % 256), std::uint8_t(i / 256)), now);
  }
  drain(UINT64_MAX);
  return arrivals;
}

}  // namespace

TEST_CASE("A channel without faults hands on everything at once") {
  UnreliableChannel channel({}, 1);
  const auto arrivals = send_through(channel, 100);
  REQUIRE(arrivals.size() == 100);
  for (int i = 0; i < 100; ++i) CHECK(arrivals[i] == Arrival{i, std::uint64_t(i) * kPeriod_ns});
}

TEST_CASE("Faults are as frequent as asked for") {
  const int count = 20000;
  UnreliableChannel channel({.loss = 0.1, .duplicate = 0.05, .reorder = 0.02}, 7);
  std::map<int, int> copies;
  for (const Arrival& arrival : send_through(channel, count)) ++copies[arrival.number];
  int twice = 0;
  for (const auto& [number, times] : copies) {
    REQUIRE(times <= 2);
    twice += times == 2 ? 1 : 0;
  }
  CHECK((count - int(copies.size())) / double(count) == Approx(0.1).margin(0.01));
  CHECK(twice / double(copies.size()) == Approx(0.05).margin(0.008));
  const ChannelCounts& counts = channel.counts();
  CHECK(counts.in == count);
  CHECK(counts.lost == count - copies.size());
  CHECK(counts.duplicated == std::uint64_t(twice));
  CHECK(counts.out == copies.size() + std::size_t(twice));
  CHECK(double(counts.held_back) / double(counts.out) == Approx(0.02).margin(0.005));
}

TEST_CASE("A datagram held back is overtaken by the next") {
  UnreliableChannel channel({.reorder = 0.2, .reorder_hold_ns = kPeriod_ns * 3 / 2}, 5);
  const auto arrivals = send_through(channel, 500);
  REQUIRE(arrivals.size() == 500);
  int overtaken = 0;
  for (std::size_t i = 1; i < arrivals.size(); ++i) {
    CHECK(arrivals[i].time_ns >= arrivals[i - 1].time_ns);
    overtaken += arrivals[i].number < arrivals[i - 1].number ? 1 : 0;
  }
  CHECK(overtaken > 50);
}

TEST_CASE("Delay and jitter stay within their bounds") {
  UnreliableChannel channel({.delay_ns = 5'000'000, .jitter_ns = 2'000'000}, 5);
  std::uint64_t least = UINT64_MAX, most = 0;
  for (const Arrival& arrival : send_through(channel, 2000)) {
    const std::uint64_t delay = arrival.time_ns - std::uint64_t(arrival.number) * kPeriod_ns;
    least = std::min(least, delay);
    most = std::max(most, delay);
  }
  CHECK(least >= 5'000'000);
  CHECK(least < 5'100'000);
  CHECK(most <= 7'000'000);
  CHECK(most > 6'900'000);
}

TEST_CASE("Equal seeds give equal channels, others do not") {
  const ChannelFaults faults{.loss = 0.1, .duplicate = 0.1, .reorder = 0.1, .delay_ns = 1000, .jitter_ns = 9'000'000};
  UnreliableChannel a(faults, 11), b(faults, 11), c(faults, 12);
  const auto arrivals = send_through(a, 300);
  CHECK(arrivals == send_through(b, 300));
  CHECK(arrivals != send_through(c, 300));
}
