#pragma once

#include <array>
#include <boost/system/error_code.hpp>
#include <cstddef>
#include <new>
#include <utility>

namespace tissued::daemon {

/// Where Asio keeps a handler that is waited for again and again, one at a time: nothing is asked of the heap.
class HandlerMemory {
 public:
  void* take(std::size_t size) {
    if (taken_ || size > bytes_.size()) return ::operator new(size);
    taken_ = true;
    return bytes_.data();
  }
  void give_back(void* memory) {
    if (memory != bytes_.data()) return ::operator delete(memory);
    taken_ = false;
  }

 private:
  alignas(std::max_align_t) std::array<std::byte, 512> bytes_;
  bool taken_ = false;
};

/// A handler's associated allocator, by which Asio asks for that.
template <typename T>
class HandlerAllocator {
 public:
  using value_type = T;

  explicit HandlerAllocator(HandlerMemory& memory) : memory_(&memory) {}
  template <typename U>
  HandlerAllocator(const HandlerAllocator<U>& other) : memory_(other.memory_) {}

  T* allocate(std::size_t count) { return static_cast<T*>(memory_->take(count * sizeof(T))); }
  void deallocate(T* memory, std::size_t) { memory_->give_back(memory); }
  template <typename U>
  bool operator==(const HandlerAllocator<U>& other) const {
    return memory_ == other.memory_;
  }

 private:
  template <typename U>
  friend class HandlerAllocator;
  HandlerMemory* memory_;
};

/// `function`, called as a handler with one error_code, that Asio keeps there. The memory must outlive it.
template <typename Function>
auto remembered(HandlerMemory& memory, Function function) {
  struct Handler {
    using allocator_type = HandlerAllocator<std::byte>;
    Function function;
    HandlerMemory* memory;
    allocator_type get_allocator() const { return allocator_type(*memory); }
    void operator()(const boost::system::error_code& error) { function(error); }
  };
  return Handler{std::move(function), &memory};
}

}  // namespace tissued::daemon
