#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "protocol/client_messages.hpp"
#include "protocol/tracker_frame.hpp"
#include "protocol/vicon_stream.hpp"

// A UDP socket on any free port of 127.0.0.1. Allocates nothing once it is there.
class LoopbackSocket {
 public:
  LoopbackSocket();
  ~LoopbackSocket();
  LoopbackSocket(const LoopbackSocket&) = delete;
  LoopbackSocket& operator=(const LoopbackSocket&) = delete;

  std::uint16_t port() const;
  void send(std::uint16_t port, std::span<const std::uint8_t> bytes) const;
  // Size of the next datagram, cut off at the buffer's; nullopt when none comes within the timeout.
  std::optional<std::size_t> receive(std::span<std::uint8_t> buffer, std::chrono::milliseconds timeout) const;

 private:
  int descriptor_;
};

// Sends tracker frames, whole or as their single datagrams.
class FakeTracker {
 public:
  explicit FakeTracker(std::uint16_t daemon_port) : daemon_port_(daemon_port) {}

  void send(const tissued::protocol::TrackerFrame& frame);
  void send(std::span<const std::uint8_t> bytes) { socket_.send(daemon_port_, bytes); }
  // The datagrams of a frame, for those who send them otherwise.
  static std::vector<tissued::protocol::TrackerPacket> packets_of(const tissued::protocol::TrackerFrame& frame);

 private:
  LoopbackSocket socket_;
  std::uint16_t daemon_port_;
  std::array<tissued::protocol::TrackerPacket, tissued::protocol::kMaxPacketsPerFrame> packets_;
};

// Speaks the client protocol, and refuses whatever of the daemon does not pass its own decoder.
class FakeClient {
 public:
  using Message = tissued::protocol::DecodedMessage;

  explicit FakeClient(std::uint16_t daemon_port) : daemon_port_(daemon_port) {}

  template <typename Request>
  std::uint32_t send(const Request& request) {
    std::array<std::uint8_t, tissued::protocol::kMaxDatagram> buffer;
    const std::uint32_t sequence = next_sequence_++;
    const auto size = tissued::protocol::encode_client_message({77, sequence, 0}, request, buffer);
    socket_.send(daemon_port_, std::span(buffer).first(size));
    return sequence;
  }
  void send_bytes(std::span<const std::uint8_t> bytes) { socket_.send(daemon_port_, bytes); }

  // The next datagram of any kind; throws std::runtime_error where it does not decode.
  std::optional<Message> receive(std::chrono::milliseconds timeout);

  // The next message of one kind, others passed over; throws std::runtime_error where it does not come in time.
  template <typename Reply>
  Reply await(std::chrono::milliseconds timeout = std::chrono::seconds(5)) {
    return await_if<Reply>([](const Reply&) { return true; }, timeout);
  }
  // The next one that the predicate accepts.
  template <typename Reply>
  Reply await_if(const std::function<bool(const Reply&)>& accepts,
                 std::chrono::milliseconds timeout = std::chrono::seconds(5)) {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    for (;;) {
      const Message message = receive_until(deadline);
      const Reply* reply = std::get_if<Reply>(&message.message);
      if (reply != nullptr && accepts(*reply)) {
        header = message.header;
        return *reply;
      }
    }
  }
  // Request and reply.
  template <typename Reply, typename Request>
  Reply ask(const Request& request) {
    const std::uint32_t sequence = send(request);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    for (;;) {
      const Message message = receive_until(deadline);
      const Reply* reply = std::get_if<Reply>(&message.message);
      if (reply != nullptr && message.header.envelope.in_reply_to == sequence) return *reply;
    }
  }
  // Takes what has come so far, and throws it away.
  void discard();

  tissued::protocol::Header header;  // of the message that await() returned last

 private:
  Message receive_until(std::chrono::steady_clock::time_point deadline);

  LoopbackSocket socket_;
  std::uint16_t daemon_port_;
  std::uint32_t next_sequence_ = 1;
  std::array<std::uint8_t, 2048> buffer_{};
};
