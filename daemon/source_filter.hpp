#pragma once

#include <boost/asio/ip/udp.hpp>

namespace tissued::daemon {

/// Has the kernel drop, before it takes room in the UDP socket's buffer, whatever does not come from there: so that a
/// flood cannot crowd out the one stream that is listened to. False where the kernel does not.
bool admit_only(int socket, const boost::asio::ip::udp::endpoint& from) noexcept;
void admit_all(int socket) noexcept;

}  // namespace tissued::daemon
