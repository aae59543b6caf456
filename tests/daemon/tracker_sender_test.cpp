#include "daemon/tracker_sender.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>

#include "protocol/frame_assembler.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

// A bare socket: what a program that knows nothing of ours would read.
class Listener {
 public:
  Listener() : descriptor_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    REQUIRE(bind(descriptor_, reinterpret_cast<sockaddr*>(&address), size) == 0);
    getsockname(descriptor_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
  }
  ~Listener() { close(descriptor_); }

  Endpoint endpoint() const { return {"127.0.0.1", port_}; }
  std::vector<std::vector<std::uint8_t>> datagrams() const {
    std::vector<std::vector<std::uint8_t>> all;
    std::array<std::uint8_t, 65536> buffer;
    for (ssize_t size; (size = recv(descriptor_, buffer.data(), buffer.size(), MSG_DONTWAIT)) >= 0;) {
      all.emplace_back(buffer.begin(), buffer.begin() + size);
    }
    return all;
  }

 private:
  int descriptor_;
  std::uint16_t port_ = 0;
};

protocol::Name name(const std::string& text) { return *protocol::Name::from(text); }

protocol::Name numbered(char prefix, int number) { return name(prefix + std::to_string(number)); }

}  // namespace

TEST_CASE("A pad goes out as Vicon Tracker sends an object") {
  const Listener listener;
  TrackerSender sender(listener.endpoint());
  protocol::TrackerFrame frame;  // no stamp: plain Vicon
  frame.frame_number = 0x01020304;
  frame.objects.push_back({name("A1"), {53.5, -0.25, 35.75}, {0.0, 0.5, -1.5}});
  REQUIRE(sender.send(frame));

  const auto datagrams = listener.datagrams();
  REQUIRE(datagrams.size() == 1);
  const auto& bytes = datagrams.front();
  REQUIRE(bytes.size() == 5 + 3 + 72);
  CHECK(std::vector<std::uint8_t>(bytes.begin(), bytes.begin() + 8) ==
        std::vector<std::uint8_t>{4, 3, 2, 1, 1, 0, 72, 0});
  CHECK(std::memcmp(bytes.data() + 8, "A1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0", 24) == 0);
  std::array<double, 6> pose;  // this machine is little-endian, as the wire is
  std::memcpy(pose.data(), bytes.data() + 32, sizeof pose);
  CHECK(pose == std::array<double, 6>{53.5, -0.25, 35.75, 0.0, 0.5, -1.5});
}

TEST_CASE("A frame of many items arrives in datagrams of at most 1024 bytes") {
  const Listener listener;
  TrackerSender sender(listener.endpoint());
  protocol::TrackerFrame frame;
  frame.frame_number = 7;
  frame.stamp_ns = 123456789;
  for (int i = 0; i < 4; ++i) frame.objects.push_back({numbered('A', i), {1.0 * i, 2, 3}, {}});
  for (int i = 0; i < 60; ++i) frame.markers.push_back({numbered('M', i), {0.5 * i, -1.0 * i, 60}, i % 7 == 0});
  for (int i = 0; i < 4; ++i) frame.truth.push_back({numbered('T', i), {1, 2, 3.0 * i}});
  REQUIRE(sender.send(frame));
  CHECK(sender.undelivered() == 0);

  const auto datagrams = listener.datagrams();
  CHECK(datagrams.size() > 3);
  CHECK(sender.datagrams() == datagrams.size());
  protocol::FrameAssembler assembler({});
  std::vector<protocol::TrackerFrame> frames;
  for (const auto& bytes : datagrams) {
    CHECK(bytes.size() <= 1024);
    protocol::TrackerDatagram datagram;
    REQUIRE(decode_tracker_datagram(bytes, datagram) == protocol::TrackerRefusal::none);
    for (const auto& finished : assembler.add(datagram, 1)) frames.push_back(finished);
  }
  REQUIRE(frames.size() == 1);
  CHECK(frames[0].frame_number == 7);
  CHECK(frames[0].stamp_ns == 123456789);
  REQUIRE(frames[0].markers.size() == 60);
  CHECK(frames[0].markers[59].position == std::array<double, 3>{29.5, -59, 60});
  CHECK(frames[0].markers[7].occluded);
  CHECK(frames[0].objects.size() == 4);
  CHECK(frames[0].truth.size() == 4);
}

TEST_CASE("A frame that no decoder would take is not sent") {
  const Listener listener;
  TrackerSender sender(listener.endpoint());
  protocol::TrackerFrame frame;
  frame.objects.push_back({name("A1"), {std::nan(""), 0, 0}, {}});
  CHECK_FALSE(sender.send(frame));
  CHECK(listener.datagrams().empty());
}

TEST_CASE("A tracker does not mind that nobody listens") {
  Endpoint nobody;
  {
    const Listener listener;
    nobody = listener.endpoint();
  }
  TrackerSender sender(nobody);
  protocol::TrackerFrame frame;
  frame.markers.push_back({name("M1"), {1, 2, 3}, false});
  for (int i = 0; i < 20; ++i) CHECK(sender.send(frame));
  CHECK(sender.datagrams() == 20);
}
