#include "daemon/sealed_port.hpp"

#include <algorithm>
#include <boost/asio/buffer.hpp>

#include "daemon/source_address.hpp"

namespace tissued::daemon {

namespace {

using boost::asio::ip::udp;

std::vector<protocol::SealedSessions::Key> keys_for(protocol::SealChannel channel,
                                                    std::span<const config::PreSharedKey> keys) {
  const auto role = channel == protocol::SealChannel::tracker ? config::KeyRole::tracker : config::KeyRole::client;
  std::vector<protocol::SealedSessions::Key> known;
  for (const config::PreSharedKey& key : keys) {
    known.push_back({protocol::SecretKey(key.secret), key.role == role || key.role == config::KeyRole::both});
  }
  return known;
}

}  // namespace

SealedPort::SealedPort(udp::socket& socket, protocol::SealChannel channel, std::span<const config::PreSharedKey> keys,
                       Counters& counters)
    : socket_(socket), counters_(counters), channel_(channel) {
  use(keys);
}

void SealedPort::use(std::span<const config::PreSharedKey> keys) {
  if (sessions_ && std::ranges::equal(keys, keys_)) return;
  keys_.assign(keys.begin(), keys.end());
  const std::uint64_t last_serial = sessions_ ? sessions_->last_serial() : 0;
  sessions_ = std::make_unique<protocol::SealedSessions>(channel_, keys_for(channel_, keys), last_serial);
}

std::optional<SealedPort::Opened> SealedPort::open(std::span<const std::uint8_t> datagram, const udp::endpoint& from) {
  const protocol::SealedSessions::Opened opened = sessions_->open(datagram, source_address(from));
  counters_.add(opened.refusal);
  if (!opened.challenge.empty()) {
    boost::system::error_code error;
    socket_.send_to(boost::asio::buffer(opened.challenge.data(), opened.challenge.size()), from, 0, error);
    counters_.add(error ? Count::sends_failed : Count::challenges_sent);
  }
  if (opened.refusal != protocol::SealRefusal::none || opened.kind != protocol::SealKind::data) return std::nullopt;
  return Opened{opened.contact, opened.payload};
}

std::span<const std::uint8_t> SealedPort::seal(Contact contact, std::span<const std::uint8_t> payload) {
  return std::span<const std::uint8_t>(buffer_).first(sessions_->seal(contact, payload, buffer_));
}

}  // namespace tissued::daemon
