#include "daemon/stamped_receive.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <thread>

#include "daemon/bound_socket.hpp"
#include "daemon/monotonic_clock.hpp"
#include "tests/daemon/loopback_peers.hpp"

using namespace tissued::daemon;
using boost::asio::ip::udp;

TEST_CASE("A datagram is stamped when it arrives, not when it is read") {
  boost::asio::io_context context;
  auto socket = bind_udp(context, "test", "127.0.0.1", 0);
  stamp_arrivals(socket.native_handle());
  const LoopbackSocket sender;
  const std::array<std::uint8_t, 3> bytes{1, 2, 3};
  std::array<std::uint8_t, 16> buffer{};

  CHECK_FALSE(receive_stamped(socket.native_handle(), buffer).has_value());
  const std::uint64_t before_ns = monotonic_ns();
  sender.send(socket.local_endpoint().port(), bytes);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const std::uint64_t read_ns = monotonic_ns();
  const auto received = receive_stamped(socket.native_handle(), buffer);
  REQUIRE(received.has_value());
  CHECK(received->size == 3);
  CHECK(std::equal(bytes.begin(), bytes.end(), buffer.begin()));
  CHECK(received->receive_ns + 1'000'000 >= before_ns);  // two clocks were read in between
  CHECK(received->receive_ns + 45'000'000 <= read_ns);
}

TEST_CASE("What is longer than the buffer is cut off") {
  boost::asio::io_context context;
  auto socket = bind_udp(context, "test", "127.0.0.1", 0);
  const LoopbackSocket sender;
  std::array<std::uint8_t, 40> bytes{};
  std::array<std::uint8_t, 16> buffer{};
  sender.send(socket.local_endpoint().port(), bytes);
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  CHECK(receive_stamped(socket.native_handle(), buffer)->size == 16);
}

TEST_CASE("Datagrams that a full buffer costs are told by the next one that is read") {
  boost::asio::io_context context;
  auto socket = bind_udp(context, "test", "127.0.0.1", 0);
  stamp_arrivals(socket.native_handle());
  socket.set_option(udp::socket::receive_buffer_size(4096));
  const LoopbackSocket sender;
  const std::array<std::uint8_t, 500> bytes{};
  std::array<std::uint8_t, 512> buffer{};
  constexpr std::uint32_t kSent = 200;
  for (std::uint32_t i = 0; i < kSent; ++i) sender.send(socket.local_endpoint().port(), bytes);
  std::uint32_t received = 0;
  while (receive_stamped(socket.native_handle(), buffer)) ++received;
  sender.send(socket.local_endpoint().port(), bytes);
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  const auto last = receive_stamped(socket.native_handle(), buffer);
  REQUIRE(last.has_value());
  CHECK(received < kSent);
  CHECK(last->drops.value() == kSent - received);
}
