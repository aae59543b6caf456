#include "daemon/stamped_receive.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "daemon/monotonic_clock.hpp"

namespace tissued::daemon {

namespace {

constexpr std::int64_t kLongestWait_ns = 1'000'000'000;

std::int64_t to_ns(const timespec& time) { return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec; }

// The kernel stamps by the wall clock, which may step: only the way from stamp to now is taken from it, in bounds.
std::uint64_t monotonic_of(const timespec& arrival) {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  const std::int64_t waited_ns = std::clamp<std::int64_t>(to_ns(now) - to_ns(arrival), 0, kLongestWait_ns);
  return monotonic_ns() - static_cast<std::uint64_t>(waited_ns);
}

}  // namespace

void stamp_arrivals(int socket) noexcept {
  const int on = 1;
  ::setsockopt(socket, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof(on));
  ::setsockopt(socket, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof(on));
}

std::optional<ReceivedDatagram> receive_stamped(int socket, std::span<std::uint8_t> buffer) noexcept {
  ReceivedDatagram datagram;
  iovec part{buffer.data(), buffer.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(std::uint32_t))> control{};
  msghdr message{};
  message.msg_name = datagram.from.data();
  message.msg_namelen = static_cast<socklen_t>(datagram.from.capacity());
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  ssize_t size = -1;
  do {
    size = ::recvmsg(socket, &message, MSG_DONTWAIT);
  } while (size < 0 && errno == EINTR);
  if (size < 0) return std::nullopt;

  datagram.size = static_cast<std::size_t>(size);
  datagram.receive_ns = monotonic_ns();
  datagram.from.resize(message.msg_namelen);
  for (cmsghdr* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header)) {
    if (header->cmsg_level != SOL_SOCKET) continue;
    if (header->cmsg_type == SO_TIMESTAMPNS) {
      timespec arrival{};
      std::memcpy(&arrival, CMSG_DATA(header), sizeof(arrival));
      datagram.receive_ns = monotonic_of(arrival);
    } else if (header->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t drops = 0;
      std::memcpy(&drops, CMSG_DATA(header), sizeof(drops));
      datagram.drops = drops;
    }
  }
  return datagram;
}

}  // namespace tissued::daemon
