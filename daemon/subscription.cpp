#include "daemon/subscription.hpp"

#include <algorithm>

#include "daemon/monotonic_clock.hpp"

namespace tissued::daemon {
namespace {

constexpr std::uint16_t kLease_s = 4;
constexpr std::uint64_t kRenewal_ns = 1'000'000'000;  // three renewals may be lost before the lease ends

}  // namespace

Subscription::Subscription(PredictionClient& client, std::uint8_t what, double rate_hz)
    : client_(client), request_{.what = what, .lease_s = kLease_s, .rate_hz = rate_hz} {}

std::optional<ReceivedMessage> Subscription::receive(std::uint64_t deadline_ns) {
  for (;;) {
    const std::uint64_t now = monotonic_ns();
    if (now >= renew_ns_) {
      client_.send(request_);
      renew_ns_ = now + kRenewal_ns;
    }
    if (auto message = client_.receive(std::min(deadline_ns, renew_ns_))) return message;
    if (monotonic_ns() < renew_ns_ || deadline_ns <= renew_ns_) return std::nullopt;
  }
}

}  // namespace tissued::daemon
