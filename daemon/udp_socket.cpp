#include "daemon/udp_socket.hpp"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <memory>
#include <stdexcept>
#include <string>

#include "daemon/monotonic_clock.hpp"

namespace tissued::daemon {
namespace {

// A mesh of 100k tetrahedra is answered in some 2 MB at once.
constexpr int kReceiveBuffer = 4 << 20;

using AddressList = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

// IPv4 before IPv6: `localhost` is both, and tissued listens on 127.0.0.1 unless told otherwise.
AddressList resolve(const Endpoint& peer) {
  int error = 0;
  for (const int family : {AF_INET, AF_INET6}) {
    addrinfo hints{};
    hints.ai_family = family;
    hints.ai_socktype = SOCK_DGRAM;
    addrinfo* found = nullptr;
    error = getaddrinfo(peer.host.c_str(), std::to_string(peer.port).c_str(), &hints, &found);
    if (error == 0) return {found, &freeaddrinfo};
  }
  throw std::runtime_error(to_string(peer) + ": " + gai_strerror(error));
}

}  // namespace

UdpSocket::UdpSocket(const Endpoint& peer) {
  const AddressList addresses = resolve(peer);
  for (const addrinfo* a = addresses.get(); a != nullptr; a = a->ai_next) {
    descriptor_ = socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, a->ai_protocol);
    if (descriptor_ < 0) continue;
    if (connect(descriptor_, a->ai_addr, a->ai_addrlen) == 0) break;
    const int error = errno;
    close(descriptor_);
    descriptor_ = -1;
    errno = error;
  }
  if (descriptor_ < 0) throw std::runtime_error(to_string(peer) + ": " + std::strerror(errno));
  // The system may grant less; then more is lost, and asked for again.
  setsockopt(descriptor_, SOL_SOCKET, SO_RCVBUF, &kReceiveBuffer, sizeof kReceiveBuffer);
}

UdpSocket::~UdpSocket() { close(descriptor_); }

bool UdpSocket::send(std::span<const std::uint8_t> datagram) noexcept {
  const auto once = [&] { return ::send(descriptor_, datagram.data(), datagram.size(), MSG_NOSIGNAL) >= 0; };
  // An earlier datagram's refusal is reported on the next call, which then sends nothing: so ask a second time.
  return once() || (errno == ECONNREFUSED && once());
}

std::optional<std::size_t> UdpSocket::receive(std::span<std::uint8_t> buffer, std::uint64_t deadline_ns) noexcept {
  for (;;) {
    const ssize_t size = recv(descriptor_, buffer.data(), buffer.size(), 0);
    if (size >= 0) return static_cast<std::size_t>(size);
    if (errno == EINTR || errno == ECONNREFUSED) continue;  // refusals: the peer may come up later
    if (!wait_readable(deadline_ns)) return std::nullopt;
  }
}

bool UdpSocket::wait_readable(std::uint64_t deadline_ns) const noexcept {
  const std::uint64_t now = monotonic_ns();
  if (now >= deadline_ns) return false;
  const std::uint64_t left = deadline_ns - now;
  const timespec timeout{static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
  pollfd entry{descriptor_, POLLIN, 0};
  // An interrupted wait counts as over: a signal is how a user ends the program.
  return ppoll(&entry, 1, &timeout, nullptr) > 0;
}

}  // namespace tissued::daemon
