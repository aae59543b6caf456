#include "protocol/replay_window.hpp"

namespace tissued::protocol {

const char* to_string(ReplayVerdict verdict) {
  switch (verdict) {
    case ReplayVerdict::fresh:
      return "fresh";
    case ReplayVerdict::replayed:
      return "replayed";
    case ReplayVerdict::too_old:
      return "too_old";
  }
  return "unknown";
}

ReplayVerdict ReplayWindow::take(std::uint64_t counter) {
  if (!started_ || counter > newest_) {
    const std::uint64_t ahead = counter - newest_;
    if (!started_ || ahead >= kSize) {
      taken_.reset();
    } else {
      // The numbers passed over take the places of those that are now too old.
      for (std::uint64_t k = 1; k < ahead; ++k) taken_.reset((newest_ + k) % kSize);
    }
    started_ = true;
    newest_ = counter;
  } else if (newest_ - counter >= kSize) {
    return ReplayVerdict::too_old;
  } else if (taken_.test(counter % kSize)) {
    return ReplayVerdict::replayed;
  }
  taken_.set(counter % kSize);
  return ReplayVerdict::fresh;
}

}  // namespace tissued::protocol
