#include "daemon/contact_socket.hpp"

#include <algorithm>

#include "daemon/monotonic_clock.hpp"

namespace tissued::daemon {
namespace {

constexpr std::uint64_t kSeek_ns = 100'000'000;  // between two first contacts

}  // namespace

ContactSocket::ContactSocket(const Endpoint& daemon, protocol::SealChannel channel,
                             const std::optional<protocol::SecretKey>& key)
    : socket_(daemon) {
  if (key) contact_.emplace(channel, *key);
}

void ContactSocket::seek_contact() noexcept {
  const std::uint64_t now = monotonic_ns();
  if (sought_ns_ != 0 && now - sought_ns_ < kSeek_ns) return;
  sought_ns_ = now;
  socket_.send(std::span(sealed_).first(contact_->seal_first_contact(sealed_)));
}

bool ContactSocket::meet(std::uint64_t deadline_ns) noexcept {
  if (!contact_) return true;
  while (!contact_->established()) {
    seek_contact();
    receive(std::min(deadline_ns, monotonic_ns() + kSeek_ns));
    if (!contact_->established() && monotonic_ns() >= deadline_ns) return false;
  }
  return true;
}

bool ContactSocket::send(std::span<const std::uint8_t> datagram) noexcept {
  if (!contact_) return socket_.send(datagram);
  if (!contact_->established()) {
    seek_contact();
    return false;
  }
  return socket_.send(std::span(sealed_).first(contact_->seal(datagram, sealed_)));
}

std::optional<std::span<const std::uint8_t>> ContactSocket::receive(std::uint64_t deadline_ns) noexcept {
  while (const auto size = socket_.receive(buffer_, deadline_ns)) {
    const auto datagram = std::span<const std::uint8_t>(buffer_).first(*size);
    if (!contact_) return datagram;
    const bool was_established = contact_->established();
    const protocol::SealedContact::Opened opened = contact_->open(datagram);
    if (opened.refusal != protocol::SealRefusal::none) {
      ++refused_;
    } else if (opened.kind == protocol::SealKind::data) {
      return opened.payload;
    } else if (contact_->established() != was_established) {
      if (was_established) seek_contact();  // the daemon does not know us any more
      if (!was_established) return std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace tissued::daemon
