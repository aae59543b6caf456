#include "protocol/text_fields.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

using namespace tissued::protocol;

TEST_CASE("numbers are read whole or not at all") {
  CHECK(parse_number("1.5") == 1.5);
  CHECK(parse_number("+1.5") == 1.5);
  CHECK(parse_number("-1e-3") == -0.001);
  CHECK(parse_number(".5") == 0.5);
  CHECK(parse_number("-1.0498318478633e-30") == -1.0498318478633e-30);
  for (const char* text : {"", "+", "-", "+-1", "++1", "1,5", "1.5 ", " 1.5", "1.5x", "0x10", "nan", "inf", "-inf",
                           "infinity", "1e400", "1e", "e5", "1d3", "."}) {
    INFO("'" << text << "'");
    CHECK_FALSE(parse_number(text));
  }
  CHECK(parse_integer("-42") == -42);
  CHECK(parse_integer("+42") == 42);
  CHECK(parse_integer("9223372036854775807") == std::numeric_limits<std::int64_t>::max());
  for (const char* text : {"", "1.0", "1e3", "9223372036854775808", "0x10", "+-1", "1 "}) {
    INFO("'" << text << "'");
    CHECK_FALSE(parse_integer(text));
  }
}

TEST_CASE("numbers are written to read back to the same bits") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-1000, 1000);
  for (int i = 0; i < 2000; ++i) {
    const double value = std::ldexp(mantissa(random), exponent(random));
    std::string text;
    append_number(text, value);
    CHECK(parse_number(text) == value);
  }
  std::string text;
  append_number(text, -0.116);
  CHECK(text == "-0.116");
}

TEST_CASE("what is quoted in a message is printable and short") {
  CHECK(in_quotes("ab c") == "'ab c'");
  CHECK(in_quotes("a\n\x01\xFFz") == "'a???z'");
  CHECK(in_quotes(std::string(50, 'x')) == "'" + std::string(40, 'x') + "...'");
  CHECK(trimmed(" \ta b\r ") == "a b");
  CHECK(trimmed(" \r").empty());
}
