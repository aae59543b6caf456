#include "tests/daemon/loopback_peers.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

using namespace tissued;

namespace {

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

}  // namespace

LoopbackSocket::LoopbackSocket() : descriptor_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const sockaddr_in any = loopback(0);
  if (descriptor_ < 0 || ::bind(descriptor_, reinterpret_cast<const sockaddr*>(&any), sizeof(any)) != 0) {
    throw std::runtime_error("no socket for the test");
  }
}

LoopbackSocket::~LoopbackSocket() { ::close(descriptor_); }

std::uint16_t LoopbackSocket::port() const {
  sockaddr_in own{};
  socklen_t size = sizeof(own);
  ::getsockname(descriptor_, reinterpret_cast<sockaddr*>(&own), &size);
  return ntohs(own.sin_port);
}

void LoopbackSocket::send(std::uint16_t port, std::span<const std::uint8_t> bytes) const {
  const sockaddr_in to = loopback(port);
  ::sendto(descriptor_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof(to));
}

std::optional<std::size_t> LoopbackSocket::receive(std::span<std::uint8_t> buffer,
                                                   std::chrono::milliseconds timeout) const {
  pollfd poll{descriptor_, POLLIN, 0};
  if (::poll(&poll, 1, static_cast<int>(timeout.count())) <= 0) return std::nullopt;
  const ssize_t size = ::recv(descriptor_, buffer.data(), buffer.size(), 0);
  return size < 0 ? std::nullopt : std::optional(static_cast<std::size_t>(size));
}

void FakeTracker::send(const protocol::TrackerFrame& frame) {
  const std::size_t count = protocol::encode_tracker_frame(frame, packets_);
  if (count == 0) throw std::runtime_error("the test's frame cannot be encoded");
  for (std::size_t i = 0; i < count; ++i) send(packets_[i].view());
}

std::vector<protocol::TrackerPacket> FakeTracker::packets_of(const protocol::TrackerFrame& frame) {
  std::vector<protocol::TrackerPacket> packets(protocol::kMaxPacketsPerFrame);
  packets.resize(protocol::encode_tracker_frame(frame, packets));
  return packets;
}

std::optional<FakeClient::Message> FakeClient::receive(std::chrono::milliseconds timeout) {
  const auto size = socket_.receive(buffer_, timeout);
  if (!size) return std::nullopt;
  const Message message = protocol::decode_client_message(std::span(buffer_).first(*size));
  if (message.refusal != protocol::ClientRefusal::none) {
    throw std::runtime_error(std::string("the daemon's datagram is refused: ") + protocol::to_string(message.refusal));
  }
  return message;
}

FakeClient::Message FakeClient::receive_until(std::chrono::steady_clock::time_point deadline) {
  using std::chrono::milliseconds;
  const auto left = std::chrono::duration_cast<milliseconds>(deadline - std::chrono::steady_clock::now());
  if (left > milliseconds(0)) {
    if (auto message = receive(left)) return *message;
  }
  throw std::runtime_error("the daemon did not answer in time");
}

void FakeClient::discard() {
  while (receive(std::chrono::milliseconds(0))) {
  }
}
