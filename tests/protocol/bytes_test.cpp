#include "protocol/bytes.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

using tissued::protocol::ByteReader;
using tissued::protocol::ByteWriter;

TEST_CASE("fields are little-endian whatever the host") {
  // 1.5 is 0x3FC00000 as float32 and 0x3FF8000000000000 as float64 (IEEE 754).
  const std::vector<std::uint8_t> golden{0x01, 0x03, 0x02, 0x07, 0x06, 0x05, 0x04, 0x0F, 0x0E,
                                         0x0D, 0x0C, 0x0B, 0x0A, 0x09, 0x08, 0x00, 0x00, 0xC0,
                                         0x3F, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xF8, 0x3F};
  std::vector<std::uint8_t> buffer(golden.size());
  ByteWriter writer(buffer);
  writer.u8(0x01);
  writer.u16(0x0203);
  writer.u32(0x04050607);
  writer.u64(0x08090A0B0C0D0E0F);
  writer.f32(1.5F);
  writer.f64(1.5);
  REQUIRE(writer.ok());
  CHECK(writer.remaining() == 0);
  CHECK(buffer == golden);

  ByteReader reader(golden);
  CHECK(reader.u8() == 0x01);
  CHECK(reader.u16() == 0x0203);
  CHECK(reader.u32() == 0x04050607);
  CHECK(reader.u64() == 0x08090A0B0C0D0E0F);
  CHECK(reader.f32() == 1.5F);
  CHECK(reader.f64() == 1.5);
  CHECK(reader.ok());
  CHECK(reader.remaining() == 0);
}

TEST_CASE("not-a-number and infinity pass through and are noticed") {
  std::array<std::uint8_t, 28> buffer{};
  ByteWriter writer(buffer);
  SECTION("among float64") {
    writer.vector({std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -0.0});
    CHECK(writer.ok());
    CHECK_FALSE(writer.finite());
    ByteReader reader(buffer);
    const auto value = reader.vector();
    CHECK(std::isnan(value[0]));
    CHECK(std::isinf(value[1]));
    CHECK(std::signbit(value[2]));
    CHECK(reader.ok());
    CHECK_FALSE(reader.finite());
  }
  SECTION("as float32") {
    writer.f32(-std::numeric_limits<float>::infinity());
    CHECK_FALSE(writer.finite());
    ByteReader reader(buffer);
    CHECK(std::isinf(reader.f32()));
    CHECK_FALSE(reader.finite());
  }
  SECTION("the largest numbers are finite") {
    writer.f64(std::numeric_limits<double>::lowest());
    writer.f32(std::numeric_limits<float>::max());
    CHECK(writer.finite());
    ByteReader reader(buffer);
    CHECK(reader.f64() == std::numeric_limits<double>::lowest());
    CHECK(reader.f32() == std::numeric_limits<float>::max());
    CHECK(reader.finite());
  }
}

TEST_CASE("a read past the end gives zero and stays failed") {
  const std::vector<std::uint8_t> bytes{0xFF, 0xFF, 0xFF};
  ByteReader reader(bytes);
  CHECK(reader.u32() == 0);
  CHECK_FALSE(reader.ok());
  CHECK(reader.remaining() == 3);
  CHECK(reader.u8() == 0);  // there would be room, but the record is already lost
  CHECK_FALSE(reader.ok());
  CHECK(ByteReader(bytes).bytes(4).empty());
  CHECK(ByteReader(bytes).bytes(3).size() == 3);
}

TEST_CASE("a write past the end writes nothing and stays failed") {
  std::vector<std::uint8_t> buffer(5, 0xEE);
  ByteWriter writer(buffer);
  writer.u32(1);
  writer.u16(0xFFFF);
  writer.u8(0xFF);
  CHECK_FALSE(writer.ok());
  CHECK(writer.size() == 4);
  CHECK(buffer == std::vector<std::uint8_t>{1, 0, 0, 0, 0xEE});
}

TEST_CASE("patching reaches only what was written") {
  std::vector<std::uint8_t> buffer(8, 0);
  ByteWriter writer(buffer);
  writer.u32(0);
  writer.u8(9);
  writer.patch_u32(1, 0x04030201);
  CHECK(writer.ok());
  CHECK(buffer == std::vector<std::uint8_t>{0, 1, 2, 3, 4, 0, 0, 0});
  SECTION("over the end") { writer.patch_u32(2, 0); }
  SECTION("far out") { writer.patch_u32(std::numeric_limits<std::size_t>::max(), 0); }
  CHECK_FALSE(writer.ok());
}
