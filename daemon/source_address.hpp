#pragma once

#include <boost/asio/ip/udp.hpp>

#include "protocol/source_address.hpp"

namespace tissued::daemon {

/// `endpoint` as seals and cookies know it.
protocol::SourceAddress source_address(const boost::asio::ip::udp::endpoint& endpoint);

}  // namespace tissued::daemon
