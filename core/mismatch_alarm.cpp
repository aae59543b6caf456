#include "core/mismatch_alarm.hpp"

#include <algorithm>
#include <cmath>

namespace tissued::core {

namespace {

constexpr double kGap = 0.5;                       // s without a frame: a new beginning
constexpr double kBlink = 0.2;                     // s: a marker that is not seen for longer is followed anew
constexpr double kWarmUp = 1.0;                    // s
constexpr double kNoiseWindow = 1.0;               // s
constexpr std::size_t kFewest = 4;                 // markers
constexpr double kFloor = 0.03;                    // mm
constexpr double kLag = 0.015;                     // s by which the simulation may be behind or ahead of a moving body
constexpr double kOfElements = 0.35;               // of what elements explain: what of it is wrong
constexpr double kForceShare = 0.08;               // of the load, where a force decides how far a pad goes
constexpr double kStill = 0.1;                     // mm
constexpr double kRest = 0.4;                      // s
constexpr double kLeastTravel = 1.0;               // mm, for a draw at rest
constexpr double kDrift = 3.0;                     // standard deviations: a misfit that moves while the load rests
constexpr double kSteadiness = 0.25;               // of v0's model error: what of it may change while the load rests
constexpr double kWildest = 16.0;                  // of a single marker's |m|^2 / (3 v0)
constexpr double kMostOfDraw = 0.5;                // of the threshold: no single load raises the alarm
constexpr double kHighest = 1.5, kCleared = 0.25;  // of the threshold

double furthest(std::span<const Vec3> a, std::span<const Vec3> b) {
  double square = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) square = std::max(square, (a[i] - b[i]).squaredNorm());
  return std::sqrt(square);
}

// share: of v0 that is the model's error.
MismatchAlarm::Evidence evidence_of(double ratio, double share) {
  const double worse = 1.0 + (MismatchAlarm::kWorse - 1.0) * share;
  return {0.5 * MismatchAlarm::kFreedoms * (ratio * (1.0 - 1.0 / worse) - std::log(worse)),
          MismatchAlarm::kSlope * share * (ratio - 1.0)};
}

}  // namespace

MismatchAlarm::MismatchAlarm(const AlarmOptions& options, std::size_t markers, double noise)
    : options_(options),
      stated_variance_(noise * noise),
      mean_(markers),
      innovation_before_(markers),
      age_(markers),
      unseen_(markers),
      moved_before_(markers),
      drawn_at_(markers),
      rested_at_(markers),
      drawn_misfit_(markers) {
  judged_.reserve(markers);
  reset();
}

void MismatchAlarm::reset() {
  forget_window();
  for (auto* places : {&drawn_at_, &drawn_misfit_}) std::fill(places->begin(), places->end(), Vec3::Zero());
  noise_variance_ = stated_variance_;
  drawn_pad_travel_ = ratio_ = 0.0;
  sums_ = evidence_ = Evidence{};
  draws_ = 0;
  report_ = MismatchReport{};
}

// The evidence stays.
void MismatchAlarm::forget_window() {
  for (auto* places : {&mean_, &innovation_before_, &moved_before_, &rested_at_})
    std::fill(places->begin(), places->end(), Vec3::Zero());
  std::fill(age_.begin(), age_.end(), 0.0);
  std::fill(unseen_.begin(), unseen_.end(), kBlink + 1.0);
  judged_.clear();
  load_ = load_square_ = speed_square_ = travel_ = elements_ = elements_square_ = 0.0;
  pad_travel_ = rested_pad_travel_ = resting_ = watched_ = 0.0;
}

double MismatchAlarm::see(const MismatchFrame& frame) {
  if (frame.dt > kGap) forget_window();
  if (!frame.sound) {
    resting_ = 0.0;
    return 0.0;
  }
  follow_noise(frame);
  follow(frame);
  follow_load(frame);
  watched_ += frame.dt;
  report_.watching = watched_ >= kWarmUp && judged_.size() >= kFewest;
  if (!report_.watching) return 0.0;

  const double v0 = variance(frame), model = model_variance(frame);
  const double ratio = misfit_ratio(v0);
  Evidence evidence;
  if (travel_ >= kFresh || (resting_ >= kRest && travel_ >= kLeastTravel)) {
    evidence = evidence_of(ratio, model / v0);
    const double fresh = std::min(1.0, travel_ / kFresh);
    evidence = {fresh * evidence.large, fresh * evidence.lasting};
  } else if (resting_ >= kRest && drift() > kDrift * std::sqrt(v0 - model + kSteadiness * kSteadiness * model)) {
    evidence = evidence_of(ratio, 1.0);
  } else {
    return 0.0;
  }
  ratio_ = ratio;
  take_draw(evidence);
  std::copy(frame.moved.begin(), frame.moved.end(), drawn_at_.begin());
  drawn_pad_travel_ = frame.pad_travel;
  return std::max({evidence.large, evidence.lasting, 0.0});
}

void MismatchAlarm::follow_noise(const MismatchFrame& frame) {
  double square = 0.0;
  int pairs = 0;
  for (int marker : frame.used) {
    if (unseen_[marker] == 0.0) {
      square += (frame.innovation[marker] - innovation_before_[marker]).squaredNorm() / 6.0;
      ++pairs;
    }
    innovation_before_[marker] = frame.innovation[marker];
  }
  if (pairs == 0) return;
  // At once up, slowly down: noise that has just begun must not pass for a misfit.
  const double seen = square / pairs;
  noise_variance_ += (seen - noise_variance_) * (1.0 - std::exp(-frame.dt / kNoiseWindow));
  noise_variance_ = std::max({noise_variance_, 0.25 * seen, stated_variance_});
}

void MismatchAlarm::follow(const MismatchFrame& frame) {
  for (double& unseen : unseen_) unseen += frame.dt;
  const double gain = 1.0 - std::exp(-frame.dt / kWindow);
  for (int marker : frame.used) {
    if (unseen_[marker] > kBlink + frame.dt) age_[marker] = 0.0;
    unseen_[marker] = 0.0;
    age_[marker] += frame.dt;
    mean_[marker] += std::max(gain, frame.dt / age_[marker]) * (frame.misfit[marker] - mean_[marker]);
    if (age_[marker] < kWindow) drawn_misfit_[marker] = mean_[marker];
  }
  judged_.clear();
  for (std::size_t i = 0; i < age_.size(); ++i)
    if (age_[i] >= kWindow && unseen_[i] <= kBlink) judged_.push_back(static_cast<int>(i));
  if (judged_.empty()) return;
  double square = 0.0;
  for (int marker : judged_) square += mean_[marker].squaredNorm() / 3.0;
  const double noise = noise_variance_ * gain / (2.0 - gain);
  report_.misfit = std::sqrt(std::max(0.0, square / static_cast<double>(judged_.size()) - noise));
}

void MismatchAlarm::follow_load(const MismatchFrame& frame) {
  double load = frame.pad_travel;
  for (const Vec3& moved : frame.moved) load = std::max(load, moved.norm());
  const double gain = 1.0 - std::exp(-frame.dt / kWindow);
  const double way = std::max(furthest(frame.moved, moved_before_), std::abs(frame.pad_travel - pad_travel_));
  const double speed = watched_ > 0.0 ? way / frame.dt : 0.0;
  speed_square_ += gain * (speed * speed - speed_square_);
  load_square_ += gain * (load * load - load_square_);
  load_ = std::max(load, std::sqrt(load_square_));
  double square = 0.0;
  for (const Vec3& element : frame.elements) square += element.squaredNorm() / 3.0;
  square /= static_cast<double>(std::max<std::size_t>(1, frame.elements.size()));
  elements_square_ += gain * (square - elements_square_);
  elements_ = std::sqrt(std::max(square, elements_square_));
  pad_travel_ = frame.pad_travel;
  std::copy(frame.moved.begin(), frame.moved.end(), moved_before_.begin());
  travel_ = std::max(furthest(frame.moved, drawn_at_), std::abs(frame.pad_travel - drawn_pad_travel_));
  const double strayed = std::max(furthest(frame.moved, rested_at_), std::abs(frame.pad_travel - rested_pad_travel_));
  resting_ += frame.dt;
  if (strayed <= kStill) return;
  std::copy(frame.moved.begin(), frame.moved.end(), rested_at_.begin());
  rested_pad_travel_ = frame.pad_travel;
  resting_ = 0.0;
}

// mm^2 per axis: what a right model may miss of the load.
double MismatchAlarm::model_variance(const MismatchFrame& frame) const {
  const double force = frame.by_force ? kForceShare : 0.0;
  const double share = options_.model_error * options_.model_error + force * force;
  return share * load_ * load_ + kOfElements * kOfElements * elements_ * elements_;
}

// And with all else.
double MismatchAlarm::variance(const MismatchFrame& frame) const {
  const double gain = 1.0 - std::exp(-frame.dt / kWindow);
  return noise_variance_ * gain / (2.0 - gain) + frame.place_sd * frame.place_sd + kFloor * kFloor +
         model_variance(frame) + kLag * kLag * speed_square_;
}

double MismatchAlarm::misfit_ratio(double variance) const {
  double sum = 0.0;
  for (int marker : judged_) sum += std::min(kWildest, mean_[marker].squaredNorm() / (3.0 * variance));
  return sum / static_cast<double>(judged_.size());
}

// mm, RMS per axis, since the newest draw.
double MismatchAlarm::drift() const {
  double square = 0.0;
  for (int marker : judged_) square += (mean_[marker] - drawn_misfit_[marker]).squaredNorm() / 3.0;
  return std::sqrt(square / static_cast<double>(judged_.size()));
}

void MismatchAlarm::take_draw(const Evidence& evidence) {
  ++draws_;
  evidence_ = evidence;
  const auto add = [](double& sum, double own, double threshold) {
    sum = std::clamp(sum + std::min(own, kMostOfDraw * threshold), 0.0, kHighest * threshold);
  };
  add(sums_.large, evidence.large, kThresholdOfLarge);
  add(sums_.lasting, evidence.lasting, kThresholdOfLasting);
  std::copy(mean_.begin(), mean_.end(), drawn_misfit_.begin());
  report_.level = std::max(sums_.large / kThresholdOfLarge, sums_.lasting / kThresholdOfLasting);
  report_.raised = report_.raised ? report_.level > kCleared : report_.level >= 1.0;
}

}  // namespace tissued::core
