#include "core/diagnosis/base_models.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/diagnosis/discretisation.hpp"
#include "core/diagnosis/placement.hpp"

namespace tissued::core {

namespace {

constexpr double kOffset = 0.5;          // mm, to which markers are placed
constexpr double kMarkerShare = 0.0045;  // of the load: what quadratic elements may err at a marker
constexpr double kForceShare = 0.03;     // of the peak force, likewise
constexpr double kForceShape = 0.004;    // of the peak force: what is noise to all that follows
// Of the load and of the peak force: what quadratic elements may err beside what goes with the load, half way there.
constexpr double kMarkerBend = 0.0015, kForceBend = 0.01;
// Of the largest displacement, RMS over trials: to what share a swing is to be explained; and for how long, s, a
// model that errs errs alike.
constexpr double kMotionShare = 0.02, kCorrelated = 0.08;
// Of what finer elements say otherwise: what a body is that is not made of elements, and recordings of one that is.
constexpr double kCorrectionMean = 0.35, kCorrectionSd = 0.35;

// N, the largest force of a pad in a trial; 0 where none was seen.
double peak_force(const RecordedTrial& trial, const Channels& channels, int pad) {
  double peak = 0.0;
  for (Eigen::Index f = 0; f < trial.seen.rows(); ++f) {
    const double force = trial.seen.row(f).segment<3>(channels.of_force(pad)).norm();
    if (std::isfinite(force)) peak = std::max(peak, force);
  }
  return peak;
}

// Pooled over the channels of a kind: a median of medians.
void pool_noise(const Channels& channels, Eigen::VectorXd& noise) {
  const auto pool = [&noise](int begin, int count) {
    if (count == 0) return;
    std::vector<double> all(noise.data() + begin, noise.data() + begin + count);
    std::nth_element(all.begin(), all.begin() + count / 2, all.end());
    noise.segment(begin, count).setConstant(all[static_cast<std::size_t>(count / 2)]);
  };
  pool(0, 3 * channels.markers);
  pool(3 * channels.markers, 3 * channels.targets);
  pool(3 * (channels.markers + channels.targets), 3 * channels.pads);
}

FitData fit_data(const RecordedSession& session, std::vector<LoadPath> paths, FemElement element,
                 const ErrorModel& errors, const std::atomic<bool>* stop) {
  FitData data;
  data.session = &session;
  data.paths = std::move(paths);
  data.errors = errors;
  data.element = element;
  data.stop = stop;
  data.judged.assign(session.trials.size(), -1.0);
  const Channels channels = channels_of(session.scene);
  for (std::size_t k = 0; k < session.trials.size(); ++k) {
    const auto keys = static_cast<Eigen::Index>(data.paths[k].keys().size());
    data.correction.push_back(RowMatrix::Zero(keys, channels.count()));
    data.force_factor.push_back(RowMatrix::Ones(keys, channels.pads));
    const auto row = static_cast<Eigen::Index>(k);
    const int seen = 3 * (channels.markers + channels.targets);
    data.errors.discretisation.row(row).head(seen).setConstant(kMarkerShare * data.paths[k].peak_load());
    data.errors.bend.row(row).head(seen).setConstant(kMarkerBend * data.paths[k].peak_load());
  }
  return data;
}

double force_ratio(const Eigen::RowVector3d& linear, const Eigen::RowVector3d& wanted) {
  constexpr double kUnloaded = 0.02, kUsual = 0.75;  // N; of linear elements' excess
  return linear.norm() > kUnloaded ? wanted.norm() / linear.norm() : kUsual;
}

}  // namespace

ErrorModel error_model(const RecordedSession& session) {
  const Channels channels = channels_of(session.scene);
  Eigen::VectorXd stated(channels.count());
  for (int c = 0; c < channels.count(); ++c) stated[c] = session.noise_of(c);
  ErrorModel errors;
  errors.noise = noise_seen(session.trials, stated);
  pool_noise(channels, errors.noise);
  errors.offset.setZero(channels.count());
  errors.offset.head(3 * channels.markers).setConstant(kOffset);
  errors.discretisation.setZero(static_cast<Eigen::Index>(session.trials.size()), channels.count());
  errors.bend = errors.discretisation;
  double largest = 0.0;
  for (std::size_t k = 0; k < session.trials.size(); ++k)
    for (int pad = 0; pad < channels.pads; ++pad) {
      const double peak = peak_force(session.trials[k], channels, pad);
      largest = std::max(largest, peak);
      const auto row = static_cast<Eigen::Index>(k);
      errors.discretisation.row(row).segment<3>(channels.of_force(pad)).setConstant(kForceShare * peak);
      errors.bend.row(row).segment<3>(channels.of_force(pad)).setConstant(kForceBend * peak);
    }
  errors.noise.tail(3 * channels.pads).array() =
      (errors.noise.tail(3 * channels.pads).array().square() + std::pow(kForceShape * largest, 2)).sqrt();
  return errors;
}

FitData fit_data(const RecordedSession& session, double travel, FemElement element, const ErrorModel& errors,
                 const std::atomic<bool>* stop) {
  std::vector<LoadPath> paths;
  for (const RecordedTrial& trial : session.trials) paths.emplace_back(trial, session.scene, travel);
  return fit_data(session, std::move(paths), element, errors, stop);
}

FitData fit_data(const RecordedSession& session, const MotionSteps& steps, const ErrorModel& errors,
                 const std::atomic<bool>* stop) {
  std::vector<LoadPath> paths;
  double square = 0.0;
  for (const RecordedTrial& trial : session.trials) {
    paths.emplace_back(trial, session.scene, steps);
    square += std::pow(paths.back().peak_load(), 2) / static_cast<double>(session.trials.size());
  }
  ErrorModel swinging = errors;
  // What a model errs swings with the body: neighbouring frames err alike.
  const double period = kCorrelated * session.scene.rate;
  swinging.noise.head(3 * channels_of(session.scene).markers).array() =
      (errors.noise.head(3 * channels_of(session.scene).markers).array().square() +
       period * kMotionShare * kMotionShare * square)
          .sqrt();
  return fit_data(session, std::move(paths), FemElement::p2, swinging, stop);
}

void place_markers(FitData& data) {
  Placement placement = placement_of(data.session->scene, data.paths, kOffset);
  data.placement = std::move(placement.slopes);
  auto known = data.errors.discretisation.leftCols(placement.doubt.cols());
  known = (known.array().square() + placement.doubt.array().square()).sqrt().matrix();
}

FinerJudgement correct_by_finer(const Fit& at, Work& work, double most_of_budget, FitData& exact) {
  const RecordedSession& session = *exact.session;
  const Channels channels = channels_of(session.scene);
  constexpr double kPushed = 1e-6;  // mm: of a trial in which nothing is pushed elements have nothing to err in
  const auto is_pushed = [](const LoadPath& path) { return path.peak_load() > kPushed; };
  FinerJudgement judgement;
  std::atomic<bool> hurried{false};
  std::vector<FinerAnswer> answers(exact.paths.size());
  std::atomic<int> waiting = static_cast<int>(std::count_if(exact.paths.begin(), exact.paths.end(), is_pushed));
  work.all(
      exact.paths.size(),
      [&](std::size_t k) {
        const LoadPath& path = exact.paths[k];
        if (!is_pushed(path)) return;
        // A body that is about to fold takes its time: no trial takes more than half of what others wait for.
        const double left = most_of_budget - work.share_of_budget();
        const bool is_waited_for = waiting-- > work.threads();
        const Allotment allotment(work, most_of_budget - (is_waited_for ? 0.5 * left : 0.0));
        if (left > 0.0)
          answers[k] = finer_answer(session.scene, at, path.keys()[path.key_at_peak()].pads, allotment.over, work.stop);
        if (allotment.over && answers[k].reached < 1.0) hurried = true;
      },
      0.1, 0.2, [&](std::size_t k) { return "the elements' own error in " + session.trials[k].name; });
  double square = 0.0, count = 0.0;
  judgement.hurried = hurried;
  for (std::size_t k = 0; k < exact.paths.size(); ++k) {
    if (!is_pushed(exact.paths[k])) continue;
    judgement.reached.push_back(answers[k].reached);
    if (!answers[k].solved() && exact.judged[k] > 0.0) continue;  // as it was judged before
    // Of what could not be judged twice as much is feared.
    exact.errors.discretisation.row(static_cast<Eigen::Index>(k)) *=
        (2.0 - answers[k].reached) / (exact.judged[k] < 0.0 ? 1.0 : 2.0 - exact.judged[k]);
    exact.judged[k] = answers[k].reached;
    if (!answers[k].solved()) continue;
    const LoadPath& path = exact.paths[k];
    for (std::size_t i = 0; i < path.keys().size(); ++i) {
      const double share = path.keys()[i].load / path.peak_load();
      const auto row = static_cast<Eigen::Index>(i);
      exact.correction[k].row(row) = kCorrectionMean * answers[k].difference(share);
      exact.force_factor[k].row(row) = answers[k].force_factor(share).array().pow(kCorrectionMean);
    }
    square += std::pow(kCorrectionMean, 2) * answers[k].difference(1.0).head(3 * channels.markers).squaredNorm();
    count += 3.0 * channels.markers;
  }
  exact.correction_sd = kCorrectionSd / kCorrectionMean;
  judgement.rms_mm = count > 0.0 ? std::sqrt(square / count) : 0.0;
  return judgement;
}

void correct_by_quadratic(FitData& fast) {
  const RecordedSession& session = *fast.session;
  const Channels channels = channels_of(session.scene);
  PathSolver linear(session.scene, {}, FemElement::p1), quadratic(session.scene, {});
  for (std::size_t k = 0; k < fast.paths.size(); ++k) {
    PathAnswer by_linear, by_quadratic;
    if (!linear.solve(fast.paths[k], 0, {}, by_linear) || !quadratic.solve(fast.paths[k], 0, {}, by_quadratic))
      continue;
    for (Eigen::Index i = 0; i < by_linear.values.rows(); ++i) {
      fast.correction[k].row(i) = by_quadratic.values.row(i) - by_linear.values.row(i);
      fast.correction[k].row(i).tail(3 * channels.pads).setZero();
      for (int pad = 0; pad < channels.pads; ++pad) {
        fast.force_factor[k](i, pad) = force_ratio(by_linear.values.row(i).segment<3>(channels.of_force(pad)),
                                                   by_quadratic.values.row(i).segment<3>(channels.of_force(pad)));
      }
    }
  }
  fast.correction_sd = 0.05;
}

void rebase(const FitData& exact, const Fit& at, FitData& fast) {
  const RecordedSession& session = *fast.session;
  const Channels channels = channels_of(session.scene);
  PathSolver linear(session.scene, at.hypothesis.effects, FemElement::p1);
  set_numbers(at.hypothesis, at.unknowns, linear);
  const double share = at.unknowns.back().value;
  for (std::size_t k = 0; k < fast.paths.size(); ++k) {
    PathAnswer by_linear;
    if (!linear.solve(fast.paths[k], 0, {}, by_linear)) continue;
    for (Eigen::Index i = 0; i < by_linear.values.rows(); ++i) {
      const PathPlace place = exact.paths[k].place(fast.paths[k].keys()[static_cast<std::size_t>(i)].time);
      Eigen::RowVectorXd wanted = Eigen::RowVectorXd::Zero(channels.count());
      for (std::size_t p = 0; p < place.keys.size(); ++p) {
        Eigen::RowVectorXd answer =
            at.answers[k].values.row(place.keys[p]) + share * exact.correction[k].row(place.keys[p]);
        for (int pad = 0; pad < channels.pads; ++pad)
          answer.segment<3>(channels.of_force(pad)) *= std::pow(exact.force_factor[k](place.keys[p], pad), share);
        wanted += place.weights[p] * answer;
      }
      fast.correction[k].row(i) = wanted - by_linear.values.row(i);
      fast.correction[k].row(i).tail(3 * channels.pads).setZero();
      for (int pad = 0; pad < channels.pads; ++pad)
        fast.force_factor[k](i, pad) = force_ratio(by_linear.values.row(i).segment<3>(channels.of_force(pad)),
                                                   wanted.segment<3>(channels.of_force(pad)));
    }
  }
}

}  // namespace tissued::core
