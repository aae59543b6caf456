#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tissued::protocol {

// Bounded little-endian reader: field by field, never a cast of the buffer, whatever the host's own order.
// A read that would pass the end returns 0, reads nothing and makes ok() false for good, so that a decoder may read a
// whole record and ask once. Does not own the bytes; no exception, no allocation.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint8_t u8() { return static_cast<std::uint8_t>(unsigned_of<1>()); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(unsigned_of<2>()); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(unsigned_of<4>()); }
  std::uint64_t u64() { return unsigned_of<8>(); }
  float f32();
  double f64();
  // Three float64 in a row: x, y, z.
  std::array<double, 3> vector();
  // The next `count` bytes as a view of the buffer; empty when there are fewer.
  std::span<const std::uint8_t> bytes(std::size_t count);

  bool ok() const { return ok_; }
  // False once a float32 or float64 read was NaN or infinite.
  bool finite() const { return finite_; }
  std::size_t remaining() const { return bytes_.size() - position_; }

 private:
  template <std::size_t kSize>
  std::uint64_t unsigned_of() {
    const auto field = bytes(kSize);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < field.size(); ++i) value |= std::uint64_t{field[i]} << (8 * i);
    return value;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  bool ok_ = true;
  bool finite_ = true;
};

// Bounded little-endian writer into a caller's buffer. A write that would pass the end writes nothing and makes ok()
// false for good; an encoder asks once at its end.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::uint8_t> buffer) : buffer_(buffer) {}

  void u8(std::uint8_t value) { unsigned_of<1>(value); }
  void u16(std::uint16_t value) { unsigned_of<2>(value); }
  void u32(std::uint32_t value) { unsigned_of<4>(value); }
  void u64(std::uint64_t value) { unsigned_of<8>(value); }
  void f32(float value);
  void f64(double value);
  void vector(const std::array<double, 3>& value);
  void bytes(std::span<const std::uint8_t> values);
  // Overwrites a field written earlier, such as a length known only at the end. Where it does not lie inside what has
  // been written, ok() becomes false.
  void patch_u32(std::size_t offset, std::uint32_t value);

  bool ok() const { return ok_; }
  // False once a NaN or an infinity was written.
  bool finite() const { return finite_; }
  std::size_t size() const { return size_; }
  std::size_t remaining() const { return buffer_.size() - size_; }

 private:
  // Room for `count` more bytes, or an empty span and ok() == false.
  std::span<std::uint8_t> claim(std::size_t count);
  void store(std::span<std::uint8_t> field, std::uint64_t value);

  template <std::size_t kSize>
  void unsigned_of(std::uint64_t value) {
    store(claim(kSize), value);
  }

  std::span<std::uint8_t> buffer_;
  std::size_t size_ = 0;
  bool ok_ = true;
  bool finite_ = true;
};

}  // namespace tissued::protocol
