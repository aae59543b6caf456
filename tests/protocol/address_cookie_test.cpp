#include "protocol/address_cookie.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/protocol/seal_samples.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;

namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000ULL;

}  // namespace

TEST_CASE("a cookie is good in its epoch and in the next") {
  const AddressCookie cookies(sample_key());
  const SourceAddress address = sample_address(1);
  for (const std::uint64_t made : {300 * kSecond_ns, 315 * kSecond_ns, 330 * kSecond_ns - 1}) {
    const auto cookie = cookies.make(address, made);
    CHECK(cookies.is_good(cookie, address, made));
    CHECK(cookies.is_good(cookie, address, 300 * kSecond_ns));
    CHECK(cookies.is_good(cookie, address, 360 * kSecond_ns - 1));
    CHECK_FALSE(cookies.is_good(cookie, address, 360 * kSecond_ns));
    CHECK_FALSE(cookies.is_good(cookie, address, 300 * kSecond_ns - 1));  // from the future
  }
}

TEST_CASE("the first epoch has none before it, the last none after it") {
  const AddressCookie cookies(sample_key());
  const SourceAddress address = sample_address(1);
  const std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
  CHECK(cookies.is_good(cookies.make(address, 0), address, 0));
  CHECK_FALSE(cookies.is_good(cookies.make(address, last), address, 0));
  CHECK(cookies.is_good(cookies.make(address, last), address, last));
}

TEST_CASE("a cookie is good for its address, its port and its start alone") {
  const AddressCookie cookies(sample_key());
  const SourceAddress address = sample_address(1);
  const auto cookie = cookies.make(address, 0);
  for (std::size_t bit = 0; bit < 128; ++bit) {
    SourceAddress other = address;
    other.ip[bit / 8] = static_cast<std::uint8_t>(other.ip[bit / 8] ^ (1U << (bit % 8)));
    CHECK_FALSE(cookies.is_good(cookie, other, 0));
    AddressCookie::Bytes changed = cookie;
    changed[bit / 8] = static_cast<std::uint8_t>(changed[bit / 8] ^ (1U << (bit % 8)));
    CHECK_FALSE(cookies.is_good(changed, address, 0));
  }
  for (std::size_t bit = 0; bit < 16; ++bit) {
    const auto port = static_cast<std::uint16_t>(address.port ^ (1U << bit));
    CHECK_FALSE(cookies.is_good(cookie, {address.ip, port}, 0));
  }
  CHECK_FALSE(AddressCookie(sample_key(1)).is_good(cookie, address, 0));
  CHECK(AddressCookie().make(address, 0) != AddressCookie().make(address, 0));
}

TEST_CASE("a cookie of any other size is none") {
  const AddressCookie cookies(sample_key());
  const SourceAddress address = sample_address(1);
  const auto cookie = cookies.make(address, 0);
  Bytes longer(cookie.begin(), cookie.end());
  longer.push_back(0);
  for (std::size_t size = 0; size <= longer.size(); ++size) {
    CHECK(cookies.is_good(std::span(longer).first(size), address, 0) == (size == 16));
  }
}
