#include "core/probe_contact.hpp"

#include <algorithm>
#include <cmath>

namespace tissued::core {

namespace {

constexpr std::size_t kMostCandidates = 512;
constexpr double kReach = 1.0;  // mm beyond the ramp's limit: what the tissue itself moves towards a probe in a step
constexpr int kMostSweeps = 20;
constexpr double kSettled = 1e-5;    // mm, of a sample in a sweep
constexpr double kImmovable = 1e-3;  // of its compliance: what pads leave of it where they as good as hold it

}  // namespace

ProbeContact::ProbeContact(const ContactSurface& surface, std::span<const Probe> probes, int most_held)
    : surface_(&surface),
      probes_(probes),
      motions_(probes.size()),
      at_(static_cast<std::size_t>(surface.count())),
      forces_(probes.size() * static_cast<std::size_t>(surface.count()), Eigen::Vector4d::Zero()) {
  for (const ContactSample& sample : surface.samples()) outwards_.push_back(sample.outwards);
  const std::size_t most = std::min(forces_.size(), kMostCandidates);
  before_.resize(most);
  candidates_.reserve(forces_.size());
  const auto size = static_cast<Eigen::Index>(most);
  compliance_.setZero(size, size);
  resisted_.setZero(most_held, size);
  moves_.setZero(size, 4);
}

void ProbeContact::forget() {
  for (ProbeMotion& motion : motions_) motion.forget();
  for (Eigen::Vector4d& force : forces_) force.setZero();
  candidates_.clear();
}

double ProbeContact::begin(std::span<const ProbeInput> inputs, const NodeField& x, const HeldNodes& held,
                           double limit) {
  candidates_.clear();
  for (std::size_t i = 0; i < at_.size(); ++i) at_[i] = position_of(surface_->samples()[i], x);
  double ahead = 0.0;
  for (std::size_t p = 0; p < probes_.size(); ++p)
    ahead = std::max(ahead, motions_[p].follow(probes_[p].shape, inputs[p], at_, outwards_, limit));
  choose(limit + kReach, held);
  fill_compliance(held);
  return ahead;
}

namespace {

// Pads have it: a probe there could only fight them. Where a hold slides one node of an edge is enough, for its
// compliance is not that of K.
bool is_held(const ContactSample& sample, const HeldNodes& held) {
  int holds = 0, moves = 0;
  for (int a = 0; a < sample.count; ++a) {
    if (sample.rows[a] < 0) continue;
    (held.holds(sample.rows[a]) ? holds : moves) += 1;
  }
  return moves == 0 || (held.slides() && holds > 0);
}

}  // namespace

// The samples within reach of a probe that are free; where there are too many, the nearest. All others bear nothing.
void ProbeContact::choose(double reach, const HeldNodes& held) {
  for (std::size_t p = 0; p < probes_.size(); ++p) {
    const ProbeMotion& motion = motions_[p];
    if (!motion.present()) continue;
    const RigidTransform probe_T_tissue = motion.pose().inverse();
    for (std::size_t i = 0; i < at_.size(); ++i) {
      const double distance = signed_distance(probes_[p].shape, probe_T_tissue(at_[i])).distance;
      if (distance > reach || is_held(surface_->samples()[i], held)) continue;
      Candidate candidate{static_cast<int>(i), static_cast<int>(p), distance};
      candidate.anchor.head<3>() = motion.moved()(at_[i]);
      candidates_.push_back(candidate);
    }
  }
  if (candidates_.size() > kMostCandidates) {
    const auto last = candidates_.begin() + kMostCandidates;
    std::nth_element(candidates_.begin(), last, candidates_.end(),
                     [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
    candidates_.erase(last, candidates_.end());
  }
  std::size_t kept = 0;
  for (const Candidate& c : candidates_) before_[kept++] = force_of(c);
  for (Eigen::Vector4d& force : forces_) force.setZero();
  for (std::size_t j = 0; j < candidates_.size(); ++j) force_of(candidates_[j]) = before_[j];
}

// A: K^-1 among the candidates, less what the pads that hold take of it. Where a hold slides, or is a support that is
// loose in part, it does not take the same on all axes; that is left to the iterations, for which a compliance that is
// too large is only slow.
void ProbeContact::fill_compliance(const HeldNodes& held) {
  const auto samples = surface_->samples();
  const int count = static_cast<int>(candidates_.size());
  const bool eliminates = held.count() > 0 && !held.slides();
  if (eliminates)
    for (int j = 0; j < count; ++j) {
      const ContactSample& sample = samples[candidates_[j].sample];
      held.resist(sample.rows, sample.weights, resisted_.col(j).head(held.count()));
    }
  for (int j = 0; j < count; ++j) {
    for (int k = 0; k <= j; ++k) {
      double a = surface_->compliance(samples[candidates_[j].sample], samples[candidates_[k].sample]);
      if (eliminates) a -= resisted_.col(j).head(held.count()).dot(resisted_.col(k).head(held.count()));
      compliance_(j, k) = compliance_(k, j) = a;
    }
    const ContactSample& sample = samples[candidates_[j].sample];
    if (compliance_(j, j) < kImmovable * surface_->compliance(sample, sample)) compliance_(j, j) = 0.0;
  }
}

void ProbeContact::add_forces(float* residual) const {
  for (const Candidate& c : candidates_) {
    const ContactSample& sample = surface_->samples()[c.sample];
    for (int a = 0; a < sample.count; ++a)
      if (sample.rows[a] >= 0)
        Eigen::Map<Eigen::Vector4f>(residual + 4 * static_cast<std::ptrdiff_t>(sample.rows[a])) +=
            (sample.weights[a] * force_of(c)).cast<float>();
  }
}

void ProbeContact::linearise(const NodeField& x) {
  for (Candidate& c : candidates_) {
    const Vec3 at = position_of(surface_->samples()[c.sample], x);
    const RigidTransform& pose = motions_[c.probe].pose();
    const SignedDistance found = signed_distance(probes_[c.probe].shape, pose.inverse()(at));
    c.gap = found.distance;
    c.normal.head<3>() = pose.rotation * found.normal;
    c.offset.head<3>() = at - c.anchor.head<3>();
  }
}

// The force on one sample that does with it what contact and friction ask for, the others' given. Returns mm by which
// that moves the sample.
double ProbeContact::relax(int j) {
  const Candidate& c = candidates_[j];
  const double compliance = compliance_(j, j);
  if (compliance <= 0.0) return 0.0;
  Eigen::Vector4d& force = force_of(c);
  const Eigen::Vector4d move = moves_.row(j).transpose();
  const double gap = c.gap + c.normal.dot(move);
  const double push = std::max(0.0, c.normal.dot(force) - gap / compliance);
  Eigen::Vector4d wanted = push * c.normal;
  if (const double friction = probes_[c.probe].friction; friction > 0.0 && push > 0.0) {
    const Eigen::Vector4d trial = force - (c.offset + move) / compliance;
    Eigen::Vector4d tangential = trial - c.normal.dot(trial) * c.normal;
    const double size = tangential.norm(), most = friction * push;
    if (size > most) tangential *= most / size;
    wanted += tangential;
  }
  const Eigen::Vector4d change = wanted - force;
  if (change.isZero(0.0)) return 0.0;
  force = wanted;
  for (int k = 0; k < static_cast<int>(candidates_.size()); ++k)
    moves_.row(k) += compliance_(k, j) * change.transpose();
  return compliance * change.norm();
}

bool ProbeContact::solve(const NodeField& x, const float* delta, std::span<float> change) {
  linearise(x);
  const int count = static_cast<int>(candidates_.size());
  for (int j = 0; j < count; ++j) {
    before_[j] = force_of(candidates_[j]);
    moves_.row(j).setZero();
    const ContactSample& sample = surface_->samples()[candidates_[j].sample];
    for (int a = 0; a < sample.count; ++a)
      if (sample.rows[a] >= 0)
        moves_.row(j) += sample.weights[a] *
                         Eigen::Map<const Eigen::RowVector4f>(delta + 4 * static_cast<std::ptrdiff_t>(sample.rows[a]))
                             .cast<double>();
  }
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double largest = 0.0;
    for (int j = 0; j < count; ++j) largest = std::max(largest, relax(j));
    if (largest < kSettled) break;
  }
  bool changed = false;
  std::fill(change.begin(), change.end(), 0.0f);
  for (int j = 0; j < count; ++j) {
    const Eigen::Vector4d more = force_of(candidates_[j]) - before_[j];
    if (more.isZero(0.0)) continue;
    changed = true;
    const ContactSample& sample = surface_->samples()[candidates_[j].sample];
    for (int a = 0; a < sample.count; ++a)
      if (sample.rows[a] >= 0)
        Eigen::Map<Eigen::Vector4f>(change.data() + 4 * static_cast<std::ptrdiff_t>(sample.rows[a])) +=
            (sample.weights[a] * more).cast<float>();
  }
  return changed;
}

double ProbeContact::penetration(const NodeField& x) const {
  double deepest = 0.0;
  for (const Candidate& c : candidates_) {
    const Vec3 at = motions_[c.probe].pose().inverse()(position_of(surface_->samples()[c.sample], x));
    deepest = std::max(deepest, -signed_distance(probes_[c.probe].shape, at).distance);
  }
  return deepest;
}

int ProbeContact::pressed() const {
  return static_cast<int>(std::count_if(candidates_.begin(), candidates_.end(),
                                        [this](const Candidate& c) { return !force_of(c).isZero(0.0); }));
}

Vec3 ProbeContact::force(int probe) const {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (const Candidate& c : candidates_)
    if (c.probe == probe) sum += force_of(c);
  return sum.head<3>() / kMillinewtonPerNewton;
}

double ProbeContact::travel(const NodeField& x, const NodeField& rest) const {
  double furthest = 0.0;
  for (const Candidate& c : candidates_) {
    if (force_of(c).isZero(0.0)) continue;
    const ContactSample& sample = surface_->samples()[c.sample];
    furthest = std::max(furthest, (position_of(sample, x) - position_of(sample, rest)).norm());
  }
  return furthest;
}

}  // namespace tissued::core
