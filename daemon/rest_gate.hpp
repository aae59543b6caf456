#pragma once

namespace tissued::daemon {

/// Decides which frames show the tissue at rest: all from the start until a pad first leaves its rest pose, and later
/// those for which all pads have been back for kSettling, because soft tissue creeps after a push.
class RestGate {
 public:
  static constexpr double kSettling = 1.0;  // s

  /// pads_at_rest: every pad seen in this frame is at its rest pose. elapsed: s since the frame before.
  bool admits(bool pads_at_rest, double elapsed) {
    if (!pads_at_rest) {
      disturb();
      return false;
    }
    if (disturbed_) still_ += elapsed;
    return !disturbed_ || still_ >= kSettling;
  }

  /// The frame admitted last did not show the tissue at rest after all.
  void disturb() {
    disturbed_ = true;
    still_ = 0.0;
  }

 private:
  bool disturbed_ = false;  // a pad has left its rest pose at least once
  double still_ = 0.0;      // s, how long all pads have been back
};

}  // namespace tissued::daemon
