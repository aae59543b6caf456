#pragma once

#include <cstdint>

#include "protocol/client_header.hpp"

namespace tissued::protocol {

enum class SequenceVerdict : std::uint8_t {
  first,      // of a session: nothing to compare with
  next,       // newer than all before
  late,       // older than the newest, not seen before: a stream of answers drops it, a set of chunks may use it
  duplicate,  // seen before
  too_old,    // further back than the window; whether it was seen is not known
};

const char* to_string(SequenceVerdict verdict);

// Judges the sequence numbers of one peer, remembering the newest and the 63 before it. A new session starts afresh.
// Numbers are compared modulo 2^32.
class SequenceGate {
 public:
  SequenceVerdict judge(const Envelope& envelope);

  // Numbers of this session passed over and not seen since.
  std::uint64_t lost() const { return lost_; }

 private:
  bool started_ = false;
  std::uint32_t session_ = 0;
  std::uint32_t newest_ = 0;
  std::uint64_t seen_ = 0;         // bit k: newest_ - k was seen
  std::uint64_t since_first_ = 0;  // newest_ less the first of the session
  std::uint64_t lost_ = 0;
};

}  // namespace tissued::protocol
