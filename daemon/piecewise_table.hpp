#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace tissued::daemon {

/// A table that arrives in pieces of any order, some of them more than once.
template <typename Entry>
class PiecewiseTable {
 public:
  /// More entries than this are not believed: the number comes from the network.
  static constexpr std::size_t kMaxEntries = std::size_t{1} << 24;

  /// Every piece says how long the table is; another length than before starts it anew. False where it is too long.
  bool resize(std::size_t total) {
    if (total > kMaxEntries) return false;
    if (begun_ && entries_.size() == total) return true;
    begun_ = true;
    entries_.assign(total, Entry{});
    known_.assign(total, 0);
    missing_ = total;
    return true;
  }

  /// Passes over an index beyond the end.
  void put(std::size_t index, const Entry& entry) {
    if (index >= entries_.size()) return;
    missing_ -= known_[index] == 0 ? 1 : 0;
    known_[index] = 1;
    entries_[index] = entry;
  }

  bool complete() const { return begun_ && missing_ == 0; }
  /// The next resize starts anew.
  void forget() { begun_ = false; }
  std::vector<Entry> take() { return std::move(entries_); }

 private:
  std::vector<Entry> entries_;
  std::vector<std::uint8_t> known_;  // (entries_) 1: has come
  std::size_t missing_ = 0;
  bool begun_ = false;
};

}  // namespace tissued::daemon
