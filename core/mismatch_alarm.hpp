// The alarm that a diagnosis is due: markers contradict the assumed physics, though the filter makes up for it.
//
// A marker's misfit m is what the filter has to make up for at it: the innovation, and what the learnt stiffness has
// taken out of it (LearntShift). A right model has one, too: e, of its elements, of which ElementError knows the linear
// part, and what its numbers' last digits do. Over a window that averages noise out it is
//   m ~ N(e, v0),  v0 = noise + place + floor^2 + (e's own error)^2 + (model_error load)^2 + (lag speed)^2   per axis,
// as large and in the same direction for as long as the load stays. So time is no evidence; what counts is that the
// load moved on: a *draw* is taken each time the body has moved by a few millimetres. With r, the mean over
// markers of |m - e|^2 / (3 v0), a draw is evidence of something large: the log of the likelihood ratio of a misfit
// that grows kWorse times as much with the load, r worth kFreedoms independent numbers, as neighbouring markers err
// alike; and of something that lasts: kSlope times what r is above 1, as far as v0 is the model's error. One-sided
// cumulative sums (Page 1954) of either raise the alarm. Where E[exp(evidence)] is at most 1 in a right model, the mean
// time between false alarms is at least exp(threshold) draws (Lorden 1971), of which there are some 1200 an hour. What
// it is, scripts/alarm measures on bodies in which nothing is missing. A misfit that moves while the load rests is a
// draw, too: something goes on in the tissue.
#pragma once

#include <span>
#include <vector>

#include "core/mismatch_report.hpp"
#include "core/simulator.hpp"

namespace tissued::core {

// What the filter knows after a frame.
struct MismatchFrame {
  double dt = 0.0;                   // s since the frame before
  std::span<const Vec3> innovation;  // (markers) mm, before the correction; of those used
  std::span<const Vec3> misfit;      // (markers) mm, likewise: with what was learnt, less what elements explain
  std::span<const Vec3> elements;    // (markers) mm, what elements explain
  std::span<const int> used;         // markers
  std::span<const Vec3> moved;       // (markers) mm, simulated, since rest
  double pad_travel = 0.0;           // mm, of the pad that is furthest from its rest pose
  double place_sd = 0.0;             // mm per axis, of the markers' places at rest
  bool by_force = false;             // a pad pushes by its force: how far, its stiffness decides
  bool sound = true;                 // the step is to be judged by: it converged, and no pad is ahead of it
};

class MismatchAlarm {
 public:
  struct Evidence {
    double large = 0.0, lasting = 0.0;
  };

  // noise: mm per axis, of a marker in one frame, as stated.
  MismatchAlarm(const AlarmOptions& options, std::size_t markers, double noise);

  void reset();
  // Returns the evidence, above 0, of a draw that was taken in this frame and speaks against the model; else 0.
  double see(const MismatchFrame& frame);
  const MismatchReport& report() const { return report_; }
  // Of the markers that are judged: mm, over the window.
  std::span<const Vec3> misfit() const { return mean_; }
  std::span<const int> judged() const { return judged_; }
  // Of the newest draw, for studies: its evidence, the mean over markers of |m - e|^2 / (3 v0), the load and the RMS of
  // e in mm; and how many were taken.
  Evidence evidence() const { return evidence_; }
  double ratio() const { return ratio_; }
  double load() const { return load_; }
  double elements() const { return elements_; }
  long draws() const { return draws_; }

  static constexpr double kWindow = 0.25;  // s
  static constexpr double kThresholdOfLarge = 16.0, kThresholdOfLasting = 8.0;
  static constexpr double kFreedoms = 6.0;
  static constexpr double kWorse = 4.0;  // in square
  static constexpr double kSlope = 0.75;
  static constexpr double kFresh = 5.0;  // mm of travel: another draw

 private:
  void forget_window();
  void follow(const MismatchFrame& frame);
  void follow_noise(const MismatchFrame& frame);
  void follow_load(const MismatchFrame& frame);
  double model_variance(const MismatchFrame& frame) const;
  double variance(const MismatchFrame& frame) const;
  double misfit_ratio(double variance) const;
  double drift() const;
  void take_draw(const Evidence& evidence);

  AlarmOptions options_;
  double stated_variance_;

  // Of every marker.
  std::vector<Vec3> mean_, innovation_before_;  // mm
  std::vector<double> age_, unseen_;            // s: how long it is followed, and since when it is not seen
  std::vector<Vec3> moved_before_, drawn_at_, rested_at_, drawn_misfit_;  // mm
  std::vector<int> judged_;

  double noise_variance_ = 0.0;  // mm^2 per axis, as seen from frame to frame, and not below what is stated
  double load_ = 0.0, load_square_ = 0.0, speed_square_ = 0.0, travel_ = 0.0;   // mm, mm^2, (mm/s)^2, mm
  double pad_travel_ = 0.0, drawn_pad_travel_ = 0.0, rested_pad_travel_ = 0.0;  // mm
  double resting_ = 0.0, watched_ = 0.0;                                        // s
  Evidence sums_, evidence_;
  double ratio_ = 0.0, elements_ = 0.0, elements_square_ = 0.0;
  long draws_ = 0;
  MismatchReport report_;
};

}  // namespace tissued::core
