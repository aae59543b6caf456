#pragma once

#include <array>
#include <cstddef>

namespace tissued::protocol {

// Up to kCapacity values held in place: what a datagram or a frame can carry is known beforehand, so nothing allocates
// and a slot between threads copies it whole.
template <typename T, std::size_t Capacity>
class FixedList {
 public:
  static constexpr std::size_t kCapacity = Capacity;

  // False, and nothing stored, where the list is full.
  bool push_back(const T& value) {
    if (size_ == Capacity) return false;
    values_[size_++] = value;
    return true;
  }
  // Makes room for `count` values to be written in place; what they hold before is unspecified. False, and unchanged,
  // where they do not fit.
  bool resize(std::size_t count) {
    if (count > Capacity) return false;
    size_ = count;
    return true;
  }
  void clear() { size_ = 0; }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T& operator[](std::size_t index) const { return values_[index]; }
  T& operator[](std::size_t index) { return values_[index]; }
  const T* begin() const { return values_.data(); }
  const T* end() const { return values_.data() + size_; }
  T* begin() { return values_.data(); }
  T* end() { return values_.data() + size_; }

 private:
  std::array<T, Capacity> values_{};
  std::size_t size_ = 0;
};

}  // namespace tissued::protocol
