#include "daemon/source_address.hpp"

namespace tissued::daemon {

protocol::SourceAddress source_address(const boost::asio::ip::udp::endpoint& endpoint) {
  using namespace boost::asio::ip;
  const address from = endpoint.address();
  const address_v6 v6 = from.is_v6() ? from.to_v6() : make_address_v6(v4_mapped, from.to_v4());
  return {v6.to_bytes(), endpoint.port()};
}

}  // namespace tissued::daemon
