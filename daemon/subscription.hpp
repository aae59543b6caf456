#pragma once

#include <cstdint>
#include <optional>

#include "daemon/prediction_client.hpp"

namespace tissued::daemon {

/// Keeps a stream of the daemon flowing: renews its lease every second, which also takes it up again after a restart of
/// the daemon. Nothing here waits for the daemon to be there.
class Subscription {
 public:
  /// The client must outlive the subscription. rate_hz as in protocol::Subscribe: 0 for every tracker frame.
  Subscription(PredictionClient& client, std::uint8_t what, double rate_hz);
  /// Ends the stream.
  ~Subscription() { client_.unsubscribe(); }
  Subscription(const Subscription&) = delete;
  Subscription& operator=(const Subscription&) = delete;

  /// The next message of any kind, or nullopt at `deadline_ns` (monotonic clock) or when a signal came.
  std::optional<ReceivedMessage> receive(std::uint64_t deadline_ns);

 private:
  PredictionClient& client_;
  protocol::Subscribe request_;
  std::uint64_t renew_ns_ = 0;
};

}  // namespace tissued::daemon
