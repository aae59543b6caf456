#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <stdexcept>
#include <string>

// Where a service manager would listen: a Unix datagram socket. `name`: a path that does not exist yet, or @ and a
// name.
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& name)
      : name_(name), descriptor_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    name.copy(address.sun_path, sizeof address.sun_path - 1);
    auto size = static_cast<socklen_t>(sizeof address);
    if (name.front() == '@') {
      address.sun_path[0] = '\0';
      size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
    }
    if (::bind(descriptor_, reinterpret_cast<const sockaddr*>(&address), size) != 0) {
      throw std::runtime_error("no notify socket for the test");
    }
  }
  ~NotifySocket() { ::close(descriptor_); }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  // For the environment of who is to notify.
  std::string variable() const { return "NOTIFY_SOCKET=" + name_; }

  // The next message; throws std::runtime_error where none comes.
  std::string receive(std::chrono::milliseconds timeout = std::chrono::seconds(20)) const {
    std::array<char, 4096> buffer;
    pollfd poll{descriptor_, POLLIN, 0};
    if (::poll(&poll, 1, static_cast<int>(timeout.count())) <= 0) throw std::runtime_error("nobody notifies");
    const ssize_t size = ::recv(descriptor_, buffer.data(), buffer.size(), 0);
    return {buffer.data(), size < 0 ? 0 : static_cast<std::size_t>(size)};
  }

 private:
  std::string name_;
  int descriptor_;
};
