#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tissued::daemon {

/// Where a UDP socket sends to: a name or an address, and a port.
struct Endpoint {
  std::string host;
  std::uint16_t port = 0;
};

/// Reads `HOST:PORT`, or `[ADDRESS]:PORT` for IPv6. nullopt where the host is empty or the port is not 1 to 65535.
std::optional<Endpoint> parse_endpoint(std::string_view text);

/// The text that parse_endpoint reads.
std::string to_string(const Endpoint& endpoint);

}  // namespace tissued::daemon
