// The other end of the wire for tests: real sockets, no tissue. It says that every target is where the tracker's truth
// items have it, plus an offset.
#pragma once

#include <netinet/in.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/endpoint.hpp"
#include "protocol/client_messages.hpp"
#include "protocol/frame_assembler.hpp"

namespace tissued::daemon {

struct FakeDaemonScript {
  std::vector<std::string> targets{"T1", "T2"};
  std::vector<std::string> pads{"A1"};
  std::vector<std::string> counters{"frames"};
  std::array<double, 3> offset{0.3, 0.0, 0.4};  // mm: an error of 0.5 mm
  double variance = 0.04;                       // mm^2, isotropic; 0: open loop
  std::vector<std::array<double, 3>> nodes;     // of the mesh
  std::vector<std::array<std::uint32_t, 4>> tets;
  bool mesh_not_available = false;
  // Asked for every datagram that is to go out, numbered from 0; true loses it.
  std::function<bool(std::uint64_t)> loses = [](std::uint64_t) { return false; };
  // Asked for every tracker frame, numbered from 0 as they come; false leaves it without a prediction.
  std::function<bool(std::uint64_t)> answers = [](std::uint64_t) { return true; };
};

class FakeDaemon {
 public:
  explicit FakeDaemon(FakeDaemonScript script);
  ~FakeDaemon();

  Endpoint tracker() const { return {"127.0.0.1", tracker_port_}; }
  Endpoint clients() const { return {"127.0.0.1", client_port_}; }
  // Tracker frames that came so far, in full.
  std::vector<protocol::TrackerFrame> frames() const;
  std::uint64_t refused() const { return refused_; }

 private:
  void run();
  void serve_tracker();
  void serve_client();
  void answer(const protocol::Header& header, const protocol::ClientMessage& request);
  void answer_names(std::uint32_t in_reply_to, protocol::NameKind kind);
  void answer_mesh(std::uint32_t in_reply_to, protocol::Precision precision);
  void answer_topology(std::uint32_t in_reply_to);
  protocol::Predictions predictions() const;
  template <typename Message>
  void send(std::uint32_t in_reply_to, const Message& message);

  FakeDaemonScript script_;
  std::uint16_t tracker_port_ = 0, client_port_ = 0;
  int tracker_socket_, client_socket_;
  sockaddr_in peer_{};
  bool subscribed_ = false;
  std::uint32_t sequence_ = 0;
  std::uint64_t sent_ = 0;
  protocol::FrameAssembler assembler_;
  std::optional<protocol::TrackerFrame> latest_;
  std::vector<protocol::TrackerFrame> frames_;
  mutable std::mutex frames_mutex_;
  std::atomic<std::uint64_t> refused_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace tissued::daemon
