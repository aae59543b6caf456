#include "protocol/bytes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tissued::protocol {

float ByteReader::f32() {
  const auto value = std::bit_cast<float>(u32());
  finite_ = finite_ && std::isfinite(value);
  return value;
}

double ByteReader::f64() {
  const auto value = std::bit_cast<double>(u64());
  finite_ = finite_ && std::isfinite(value);
  return value;
}

std::array<double, 3> ByteReader::vector() {
  const double x = f64();
  const double y = f64();
  const double z = f64();
  return {x, y, z};
}

std::span<const std::uint8_t> ByteReader::bytes(std::size_t count) {
  if (!ok_ || count > remaining()) {
    ok_ = false;
    return {};
  }
  const auto field = bytes_.subspan(position_, count);
  position_ += count;
  return field;
}

void ByteWriter::f32(float value) {
  finite_ = finite_ && std::isfinite(value);
  u32(std::bit_cast<std::uint32_t>(value));
}

void ByteWriter::f64(double value) {
  finite_ = finite_ && std::isfinite(value);
  u64(std::bit_cast<std::uint64_t>(value));
}

void ByteWriter::vector(const std::array<double, 3>& value) {
  for (const double component : value) f64(component);
}

void ByteWriter::bytes(std::span<const std::uint8_t> values) {
  const auto field = claim(values.size());
  if (!field.empty()) std::copy(values.begin(), values.end(), field.begin());
}

void ByteWriter::patch_u32(std::size_t offset, std::uint32_t value) {
  if (offset > size_ || size_ - offset < 4) {
    ok_ = false;
    return;
  }
  store(buffer_.subspan(offset, 4), value);
}

std::span<std::uint8_t> ByteWriter::claim(std::size_t count) {
  if (!ok_ || count > remaining()) {
    ok_ = false;
    return {};
  }
  const auto field = buffer_.subspan(size_, count);
  size_ += count;
  return field;
}

void ByteWriter::store(std::span<std::uint8_t> field, std::uint64_t value) {
  for (std::size_t i = 0; i < field.size(); ++i) field[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

}  // namespace tissued::protocol
