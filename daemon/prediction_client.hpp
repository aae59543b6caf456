#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/contact_socket.hpp"
#include "daemon/joined_view.hpp"
#include "daemon/target_answer.hpp"
#include "protocol/client_messages.hpp"
#include "protocol/sequence_gate.hpp"

namespace tissued::daemon {

/// The daemon did not answer, or not in full, however often it was asked.
class NoAnswer : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The daemon answered that it will not: what() says why.
class RequestRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// How long a request waits for its answer before it is sent again, and how often it is sent.
struct Patience {
  std::chrono::milliseconds timeout{200};
  int attempts = 10;
};

/// One message of the daemon, as it came.
struct ReceivedMessage {
  protocol::Envelope envelope;
  protocol::ClientMessage message;
  std::uint64_t receive_ns = 0;  ///< our monotonic clock
  protocol::SequenceVerdict verdict = protocol::SequenceVerdict::first;
};

/// The daemon's status with its counters by name.
struct DaemonStatus {
  protocol::Status frame;  ///< the scalars; its own list holds the last part only
  std::vector<std::pair<std::string, std::uint64_t>> counters;
};

/// Node positions of one tracker frame.
struct ReceivedMesh {
  std::uint32_t tracker_frame = 0;
  std::vector<std::array<double, 3>> nodes;  ///< (n x 3) mm, tracker frame
};

/// Speaks the client protocol with one daemon over one socket. A request is repeated until its answer is complete; what
/// else arrives meanwhile is passed over. Where there is a key, everything is sealed; where there is none, and the
/// daemon asks for it, the client shows that it receives where it sends from. Not for two threads.
class PredictionClient {
 public:
  /// Throws std::runtime_error where there is no such host. Sends nothing yet.
  explicit PredictionClient(const Endpoint& daemon, const std::optional<protocol::SecretKey>& key = std::nullopt,
                            Patience patience = {});

  /// Each throws NoAnswer or RequestRefused.
  protocol::HelloReply hello();
  std::vector<std::string> names(protocol::NameKind kind);
  TargetAnswer targets();
  DaemonStatus status();
  /// Of every probe, at one tracker frame. RequestRefused where the daemon has none.
  std::vector<JoinedView> probes();
  ReceivedMesh mesh(protocol::Precision precision);
  /// Corners as node indices from 0; of a triangle the fourth is 0.
  std::vector<std::array<std::uint32_t, 4>> cells(protocol::CellKind kind);
  protocol::SubscribeReply subscribe(const protocol::Subscribe& request);
  /// Tells the daemon to stop its stream; does not wait for the answer, since the lease ends it anyway.
  void unsubscribe();

  /// Sends without waiting. Returns the sequence number, by which the answer can be known.
  template <typename Message>
  std::uint32_t send(const Message& message) {
    if (!address_proven_) send_one(protocol::ProveAddress{});
    return send_one(message);
  }

  /// The next message, or nullopt at `deadline_ns` (monotonic clock) or when a signal came. Datagrams that do not pass
  /// the protocol's gates, and duplicates, are counted and dropped.
  std::optional<ReceivedMessage> receive(std::uint64_t deadline_ns);

  const Endpoint& daemon() const { return daemon_; }
  std::uint64_t refused() const { return refused_ + socket_.refused(); }  ///< datagrams that did not pass a gate
  std::uint64_t duplicates() const { return duplicates_; }                ///< datagrams that had come before
  std::uint64_t lost() const { return gate_.lost(); }  ///< datagrams that the daemon sent and that never came

 private:
  template <typename Message>
  std::uint32_t send_one(const Message& message) {
    std::array<std::uint8_t, protocol::kMaxDatagram> buffer;
    const protocol::Envelope envelope{session_, ++sequence_, 0};
    socket_.send(std::span(buffer).first(protocol::encode_client_message(envelope, message, buffer)));
    return sequence_;
  }
  bool speaks_of_address(const protocol::ClientMessage& message);

  // Sends `request` until `take`, shown every answer to it, has said that it is complete.
  template <typename Message>
  void ask(const Message& request, const std::function<bool(const ReceivedMessage&)>& take);
  void throw_if_refused(const ReceivedMessage& received) const;

  Endpoint daemon_;
  Patience patience_;
  ContactSocket socket_;
  bool address_proven_ = true;  // or nobody asked for it yet
  std::uint32_t session_;
  std::uint32_t sequence_ = 0;
  protocol::SequenceGate gate_;
  std::uint64_t refused_ = 0;
  std::uint64_t duplicates_ = 0;
};

}  // namespace tissued::daemon
