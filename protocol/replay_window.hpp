#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>

namespace tissued::protocol {

enum class ReplayVerdict : std::uint8_t {
  fresh,     // not taken before
  replayed,  // taken before
  too_old,   // further back than the window; whether it was taken is not known
};

const char* to_string(ReplayVerdict verdict);

// Takes every counter of one session once, remembering the newest and the 1023 before it. Ask only of datagrams whose
// tag is right: anybody else could push the window ahead of its sender.
class ReplayWindow {
 public:
  static constexpr std::size_t kSize = 1024;

  ReplayVerdict take(std::uint64_t counter);

 private:
  bool started_ = false;
  std::uint64_t newest_ = 0;
  std::bitset<kSize> taken_;  // bit c % kSize: counter c, of the newest kSize
};

}  // namespace tissued::protocol
