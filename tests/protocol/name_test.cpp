#include "protocol/name.hpp"

#include <catch2/catch.hpp>
#include <string>

using tissued::protocol::Name;

namespace {

std::array<std::uint8_t, 24> padded_bytes(std::string_view text) {
  std::array<std::uint8_t, 24> bytes{};
  for (std::size_t i = 0; i < text.size(); ++i) bytes[i] = static_cast<std::uint8_t>(text[i]);
  return bytes;
}

}  // namespace

TEST_CASE("names of 1 to 24 printable characters survive padding") {
  for (const std::string& text :
       {std::string("A"), std::string("M01"), std::string("two words"), std::string(24, 'x')}) {
    const auto name = Name::from(text);
    REQUIRE(name);
    CHECK(name->view() == text);
    CHECK(name->padded() == padded_bytes(text));
    CHECK(Name::from_padded(padded_bytes(text)) == name);
  }
}

TEST_CASE("bad names are refused") {
  CHECK_FALSE(Name::from(""));
  CHECK_FALSE(Name::from(std::string(25, 'x')));
  for (int byte = 0; byte < 256; ++byte) {
    const std::string text{'M', static_cast<char>(byte), '1'};
    CHECK(Name::from(text).has_value() == (byte >= 0x20 && byte <= 0x7E));
  }
}

TEST_CASE("padded names: every byte after the first zero must be zero") {
  CHECK_FALSE(Name::from_padded(padded_bytes("")));
  for (std::size_t i = 4; i < 24; ++i) {
    auto bytes = padded_bytes("M01");
    bytes[i] = 'x';
    CHECK_FALSE(Name::from_padded(bytes));
  }
  const auto bytes = padded_bytes("M01");
  for (std::size_t size = 0; size < 24; ++size) CHECK_FALSE(Name::from_padded(std::span(bytes).first(size)));
}
