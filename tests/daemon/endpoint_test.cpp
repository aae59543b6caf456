#include "daemon/endpoint.hpp"

#include <catch2/catch.hpp>

using namespace tissued::daemon;

TEST_CASE("An endpoint is a host and a port") {
  const auto endpoint = parse_endpoint("tracker.lab:51001");
  REQUIRE(endpoint);
  CHECK(endpoint->host == "tracker.lab");
  CHECK(endpoint->port == 51001);
  CHECK(to_string(*endpoint) == "tracker.lab:51001");
}

TEST_CASE("An IPv6 endpoint stands in brackets") {
  const auto endpoint = parse_endpoint("[fe80::1]:65535");
  REQUIRE(endpoint);
  CHECK(endpoint->host == "fe80::1");
  CHECK(endpoint->port == 65535);
  CHECK(to_string(*endpoint) == "[fe80::1]:65535");
}

TEST_CASE("What is no endpoint is refused") {
  for (const char* text : {"", ":", "host", "host:", ":51001", "host:0", "host:65536", "host:-1", "host:5x", "host: 5",
                           "::1:51001", "[]:5", "host:99999999999999999999"}) {
    INFO(text);
    CHECK_FALSE(parse_endpoint(text));
  }
}
