#include "daemon/peer_table.hpp"

#include <catch2/catch.hpp>

using boost::asio::ip::udp;
using tissued::daemon::Grant;
using tissued::daemon::Peer;
using tissued::daemon::PeerTable;

namespace {

udp::endpoint at_port(std::uint16_t port) { return {boost::asio::ip::make_address("127.0.0.1"), port}; }

}  // namespace

TEST_CASE("A client keeps its place and its sequence") {
  PeerTable table(4);
  table.hear(at_port(1), 10).next_sequence = 7;
  table.hear(at_port(2), 11);
  CHECK(table.hear(at_port(1), 12).next_sequence == 7);
  CHECK(table.find(at_port(1))->heard_ns == 12);
  CHECK(table.find(at_port(3)) == nullptr);
}

TEST_CASE(
    "Subscribers are never forgotten, visitors are, the longest silent first, and their sequence does not go back") {
  PeerTable table(2);
  REQUIRE(table.subscribe(table.hear(at_port(1), 1), Grant{}));
  table.hear(at_port(2), 2).next_sequence = 1000;
  for (std::uint16_t port = 3; port < 300; ++port) table.hear(at_port(port), port);
  CHECK(table.find(at_port(1)) != nullptr);
  CHECK(table.find(at_port(2)) == nullptr);
  CHECK(table.find(at_port(299)) != nullptr);
  CHECK(table.find(at_port(299 - PeerTable::kVisitors + 1)) != nullptr);
  CHECK(table.hear(at_port(2), 1000).next_sequence >= 1000);
}

TEST_CASE("There is room for so many subscribers and no more") {
  PeerTable table(2);
  Peer& first = table.hear(at_port(1), 1);
  CHECK(table.subscribe(first, Grant{}));
  CHECK(table.subscribe(first, Grant{}));  // again: the same place
  CHECK(table.subscribe(table.hear(at_port(2), 2), Grant{}));
  CHECK_FALSE(table.subscribe(table.hear(at_port(3), 3), Grant{}));
  CHECK(table.subscriber_count() == 2);
  table.unsubscribe(*table.find(at_port(1)));
  table.unsubscribe(*table.find(at_port(1)));
  CHECK(table.subscriber_count() == 1);
  CHECK(table.subscribe(*table.find(at_port(3)), Grant{}));
}
