// The alarm that a diagnosis is due: what it is fed against brute force, its statistic against its formula written
// once more, what must not raise it, and twins with and without something missing.
#include <catch2/catch.hpp>

#include "core/admm_simulator.hpp"
#include "core/effects/effect.hpp"
#include "core/static_solve.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr double kWeightScale = 4.0;

std::vector<PadInput> pushed(const Scene& scene, std::size_t pad, double depth) {
  std::vector<PadInput> pads(scene.pads.size());
  pads[pad].kind = PadInput::Kind::pose;
  pads[pad].center = scene.pads[pad].center + depth * scene.pads[pad].direction;
  return pads;
}

// Markers that all miss by the same, on a body that all moves by the same.
class Drive {
 public:
  explicit Drive(double noise = 0.1) : alarm_(options(), kMarkers, noise), noise_(noise) { all(); }

  static AlarmOptions options() {
    AlarmOptions options;
    options.enabled = true;
    options.model_error = 0.02;
    return options;
  }
  void all() {
    used_.clear();
    for (int i = 0; i < kMarkers; ++i) used_.push_back(i);
  }
  void step(double load, const Vec3& misfit, double dt = 0.01) {
    for (int i = 0; i < kMarkers; ++i) {
      moved_[static_cast<std::size_t>(i)] = Vec3(0.0, 0.0, -load);
      innovation_[static_cast<std::size_t>(i)] =
          misfit + noise_ * loud_ * Vec3(symmetric_random(generator_), symmetric_random(generator_), 0.0);
    }
    MismatchFrame frame;
    frame.dt = dt;
    frame.innovation = frame.misfit = innovation_;
    frame.elements = elements_;
    frame.moved = moved_;
    frame.used = used_;
    frame.pad_travel = load;
    frame.place_sd = 0.02;
    frame.sound = sound_;
    alarm_.see(frame);
  }
  void hold(double seconds, double load, const Vec3& misfit) {
    for (int k = 0; k < static_cast<int>(std::lround(seconds * 100.0)); ++k) step(load, misfit);
  }
  const MismatchReport& report() const { return alarm_.report(); }
  MismatchAlarm& alarm() { return alarm_; }

  static constexpr int kMarkers = 9;
  double loud_ = 1.0;
  bool sound_ = true;
  std::vector<int> used_;

 private:
  MismatchAlarm alarm_;
  double noise_;
  std::vector<Vec3> innovation_ = std::vector<Vec3>(kMarkers, Vec3::Zero()), moved_ = innovation_,
                    elements_ = innovation_;
  std::mt19937 generator_{5};
};

// A scene, the truth about it by quadratic elements, and the alarm of a simulator that is told what markers do.
class Twin {
 public:
  Twin(const Scene& scene, const std::vector<EffectSetting>& effects, int threads = 1) : scene_(scene) {
    SimulatorOptions truth;
    truth.kind = "fem";
    truth.effects = effects;
    truth_ = make_simulator(scene, truth);
    SimulatorOptions options;
    options.solver.time_step = kStep;
    options.solver.threads = threads;
    options.alarm.enabled = true;
    simulator_ = make_simulator(scene, options);
    observation_.resize_for(scene);
    observation_.dt = kStep;
  }

  // Rest, ramp, hold, and back, twice with every pad. Truths are solved once.
  void play(double depth, int rounds = 2) {
    constexpr int kRamp = 20;
    rest(60);
    for (int round = 0; round < rounds; ++round)
      for (std::size_t pad = 0; pad < scene_.pads.size(); ++pad) {
        if (ways_.size() <= pad) ways_.push_back(solve(pad, depth, kRamp));
        for (int k = 0; k <= kRamp; ++k) step(pushed(scene_, pad, depth * k / kRamp), ways_[pad][k]);
        for (int k = 0; k < 50; ++k) step(pushed(scene_, pad, depth), ways_[pad][kRamp]);
        for (int k = kRamp; k >= 0; --k) step(pushed(scene_, pad, depth * k / kRamp), ways_[pad][k]);
        rest(30);
      }
  }
  void rest(int frames) {
    const std::vector<Vec3> still(scene_.markers.size(), Vec3::Zero());
    for (int k = 0; k < frames; ++k) step(std::vector<PadInput>(scene_.pads.size()), still);
  }
  bool raised() const { return raised_; }
  const StepReport& report() const { return report_; }
  const std::vector<MismatchReport>& reports() const { return reports_; }

 private:
  static constexpr double kStep = 0.02;  // s

  std::vector<std::vector<Vec3>> solve(std::size_t pad, double depth, int steps) {
    truth_->reset();
    std::vector<std::vector<Vec3>> way;
    for (int k = 0; k <= steps; ++k) {
      observation_.pads = pushed(scene_, pad, depth * k / steps);
      REQUIRE(truth_->step(observation_).converged);
      way.emplace_back();
      for (std::size_t i = 0; i < scene_.markers.size(); ++i)
        way.back().push_back(truth_->marker(static_cast<int>(i)) - scene_.markers[i].rest);
    }
    return way;
  }
  void step(const std::vector<PadInput>& pads, const std::vector<Vec3>& moved) {
    observation_.pads = pads;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      observation_.marker_seen[i] = 1;
      observation_.markers[i] = scene_.markers[i].rest + moved[i] + 0.1 * random_vector(generator_);
    }
    report_ = simulator_->step(observation_);
    reports_.push_back(report_.mismatch);
    raised_ = raised_ || report_.mismatch.raised;
  }

  Scene scene_;
  std::unique_ptr<Simulator> truth_, simulator_;
  Observation observation_;
  std::vector<std::vector<std::vector<Vec3>>> ways_;  // (pads) (steps) (markers)
  StepReport report_;
  std::vector<MismatchReport> reports_;
  bool raised_ = false;
  std::mt19937 generator_{7};
};

Scene twin_scene() {
  Scene scene = box_scene({6, 5, 4, 10.0}, 16);
  scene.marker_noise = 0.1;
  return scene;
}

std::vector<EffectSetting> inclusion(const Vec3& center, double radius, double ratio) {
  const Effect* effect = find_effect("inclusion");
  std::vector<double> values;
  for (const EffectParameter& parameter : effect->parameters())
    values.push_back(parameter.name == "center.x"   ? center.x()
                     : parameter.name == "center.y" ? center.y()
                     : parameter.name == "center.z" ? center.z()
                     : parameter.name == "radius"   ? radius
                     : parameter.name == "ratio"    ? ratio
                                                    : parameter.neutral);
  return {{effect, values}};
}

}  // namespace

TEST_CASE("what the learnt stiffness moves is what taking it away would undo", "[alarm]") {
  const Scene scene = twin_scene();
  Model model(scene, Element::smoothed, kWeightScale, kQuasiStatic);
  AdmmWorkspace workspace(model, 1);
  AdmmState assumed(model), learnt(model);
  for (std::size_t slot = 0; slot < model.blocks().domain.size(); ++slot) {
    if (model.blocks().domain[slot] < 0) continue;
    double x = 0.0;
    const std::vector<int>& anchors = model.domains()[model.blocks().domain[slot]].anchors;
    for (int node : anchors) x += scene.mesh.node(node).x() / static_cast<double>(anchors.size());
    learnt.domains[slot / kLanes].factor[slot % kLanes] = std::exp(0.015 * x);
  }
  const std::vector<PadInput> pads = pushed(scene, 0, 3.0);
  const auto settle = [&](AdmmState& state) {
    begin_step(model, state, workspace, pads, kQuasiStatic, 100.0);
    for (int k = 0; k < 600; ++k) {
      local_stage(model, state, workspace);
      global_stage(model, state, workspace, kQuasiStatic);
    }
  };
  settle(assumed);
  settle(learnt);
  RestCompliance compliance(model);
  compliance.hold(std::vector<std::uint8_t>{1, 0});
  LearntShift shift(model);
  for (int k = 0; k < 200; ++k) shift.advance(model, compliance, learnt);
  double miss = 0.0, size = 0.0;
  for (std::size_t i = 0; i < scene.markers.size(); ++i) {
    const MaterialPoint& point = model.marker_points()[i];
    const Vec3 moved = position_of(point, learnt.x) - position_of(point, assumed.x);
    miss += (shift.at_marker(static_cast<int>(i)) - moved).squaredNorm();
    size += moved.squaredNorm();
  }
  REQUIRE(std::sqrt(size) > 0.05);
  CHECK(std::sqrt(miss / size) < 0.15);
}

TEST_CASE("the elements' own error is that of small pushes", "[alarm]") {
  const Scene scene = twin_scene();
  REQUIRE(scene.mesh.tet_count() > ElementError::kMostRefinedTets);
  Model model(scene, Element::smoothed, kWeightScale, 0.01);
  RestCompliance compliance(model);
  const ElementError error(model, compliance);
  REQUIRE(error.known());
  SimulatorOptions options;
  options.kind = "fem";
  const auto judge = make_simulator(scene, options);
  Observation observation;
  observation.resize_for(scene);
  observation.pads = pushed(scene, 1, 0.2);
  judge->step(observation);
  const StaticSolution own = solve_static(scene, observation.pads, {});
  REQUIRE(own.converged);
  double miss = 0.0, size = 0.0;
  for (std::size_t i = 0; i < scene.markers.size(); ++i) {
    const MaterialPoint& point = model.marker_points()[i];
    const Vec3 difference = judge->marker(static_cast<int>(i)) - scene.markers[i].rest -
                            (position_of(point, own.positions) - position_of(point, model.rest()));
    miss += (error.at(static_cast<int>(i), observation.pads) - difference).squaredNorm();
    size += difference.squaredNorm();
  }
  CHECK(std::sqrt(miss / size) < 0.1);
}

TEST_CASE("a draw's evidence is its excess, and staying under a load is none", "[alarm]") {
  Drive drive(0.0);
  drive.hold(2.0, 0.0, Vec3::Zero());
  CHECK(drive.report().watching);
  CHECK(drive.report().level == 0.0);
  const Vec3 misfit(0.4, -0.4, 0.3);
  double load = 0.0;
  double large = 0.0, lasting = 0.0;
  for (int draws = 1; draws <= 2; ++draws) {
    const long taken = drive.alarm().draws();
    while (drive.alarm().draws() == taken) drive.step(load += 0.02, misfit);
    // Way of 5 mm: as much evidence as a draw can have. v0 as its parts are said to be; the speed is 2 mm/s.
    const double model = std::pow(0.02 * load, 2);
    const double v0 = 0.02 * 0.02 + 0.03 * 0.03 + model + std::pow(0.015 * 2.0, 2);
    const double ratio = misfit.squaredNorm() / (3.0 * v0);
    REQUIRE(ratio > 1.5);
    CHECK(drive.alarm().ratio() == Approx(ratio).epsilon(0.02));
    const double worse = 1.0 + 3.0 * model / v0;
    large += std::min(8.0, 3.0 * (ratio * (1.0 - 1.0 / worse) - std::log(worse)));
    lasting += std::min(4.0, 0.75 * model / v0 * (ratio - 1.0));
    CHECK(drive.report().level == Approx(std::max(large / 16.0, lasting / 8.0)).epsilon(0.05));
  }
  drive.hold(1.0, load, misfit);
  // However long it stays there, that is all.
  const double level = drive.report().level;
  drive.hold(600.0, load, misfit);
  CHECK(drive.report().level == level);
  CHECK(drive.report().misfit == Approx(misfit.norm() / std::sqrt(3.0)).epsilon(1e-6));
}

TEST_CASE("at rest under a load a draw's variance is that of its formula", "[alarm]") {
  // So slowly there that speed is next to nothing in the window.
  Drive drive(0.0);
  drive.hold(2.0, 0.0, Vec3::Zero());
  const Vec3 misfit(0.3, -0.2, 0.1);
  double load = 0.0;
  while (load < 13.99) drive.step(load += 0.02, misfit);
  const long draws = drive.alarm().draws();
  CHECK(draws >= 2);  // at 5 and 10 mm
  CHECK(draws <= 3);
  drive.hold(0.2, load, misfit);
  CHECK(drive.alarm().draws() == draws);
  drive.hold(0.5, load, misfit);
  REQUIRE(drive.alarm().draws() == draws + 1);
  const double v0 = 0.02 * 0.02 + 0.03 * 0.03 + std::pow(0.02 * load, 2);
  CHECK(drive.alarm().ratio() == Approx(misfit.squaredNorm() / (3.0 * v0)).epsilon(0.01));
}

TEST_CASE("loads that are all missed raise the alarm, loads that are not clear it", "[alarm]") {
  Drive drive;
  const auto push = [&](const Vec3& misfit) {
    for (double load = 0.0; load < 12.0; load += 0.1) drive.step(load, load / 12.0 * misfit);
    drive.hold(1.0, 12.0, misfit);
    for (double load = 12.0; load > 0.0; load -= 0.1) drive.step(load, load / 12.0 * misfit);
    drive.hold(1.0, 0.0, Vec3::Zero());
  };
  drive.hold(2.0, 0.0, Vec3::Zero());
  for (int k = 0; k < 100; ++k) push(Vec3(0.2, 0.2, 0.0));
  CHECK_FALSE(drive.report().raised);
  int pushes = 0;
  while (!drive.report().raised && pushes < 20) {
    push(Vec3(1.0, 1.0, 0.0));
    ++pushes;
  }
  CHECK(pushes >= 1);
  CHECK(pushes <= 5);
  drive.hold(60.0, 0.0, Vec3::Zero());
  CHECK(drive.report().raised);  // rest says nothing new
  pushes = 0;
  while (drive.report().raised && pushes < 50) {
    push(Vec3::Zero());
    ++pushes;
  }
  CHECK_FALSE(drive.report().raised);
  drive.alarm().reset();
  CHECK(drive.report().level == 0.0);
  CHECK_FALSE(drive.report().watching);
}

TEST_CASE("noise, gaps, markers that come and go, and steps that are not sound raise nothing", "[alarm]") {
  Drive drive;
  std::mt19937 generator(3);
  drive.hold(2.0, 0.0, Vec3::Zero());
  for (int k = 0; k < 60; ++k) {
    const double depth = 5.0 + 8.0 * (0.5 + 0.5 * symmetric_random(generator));
    drive.loud_ = k % 5 == 0 ? 8.0 : 1.0;
    if (k % 7 == 3) drive.step(0.0, Vec3::Zero(), 3.0);  // 3 s without a frame
    for (double load = 0.0; load < depth; load += 0.15) {
      drive.all();
      std::erase_if(drive.used_, [&](int) { return generator() % 4 == 0; });
      // A simulation that lags says so.
      drive.sound_ = !(k % 6 == 1 && load < 4.0);
      drive.step(load, drive.sound_ ? Vec3(Vec3::Zero()) : Vec3(3.0, 0.0, 0.0));
    }
    if (k % 4 == 2) drive.used_ = {0, 3};
    drive.hold(0.7, depth, Vec3::Zero());
    drive.all();
    drive.hold(0.3, depth, Vec3::Zero());
    for (double load = depth; load > 0.0; load -= 0.15) drive.step(load, Vec3::Zero());
    CHECK(drive.report().level < 0.2);
  }
}

TEST_CASE("a right model raises nothing, a hidden lump does, and is found where it is", "[alarm]") {
  const Scene scene = twin_scene();
  Twin null(scene, {});
  null.play(8.0);
  CHECK_FALSE(null.raised());
  CHECK(null.report().mismatch.watching);

  const Vec3 center(30.0, 25.0, 24.0);
  Twin lump(scene, inclusion(center, 16.0, 20.0));
  lump.play(10.0, 5);
  double highest = 0.0, misfit = 0.0;
  for (const MismatchReport& report : lump.reports()) {
    highest = std::max(highest, report.level);
    misfit = std::max(misfit, report.misfit);
  }
  INFO("level " << highest << ", misfit " << misfit << " mm");
  CHECK(lump.raised());
  REQUIRE(lump.report().mismatch.has_place);
  INFO("found at " << lump.report().mismatch.place.transpose());
  CHECK((lump.report().mismatch.place - center).norm() < 20.0);
}

TEST_CASE("the alarm is the same to the bit on one thread and on two", "[alarm]") {
  const Scene scene = twin_scene();
  Twin one(scene, inclusion(Vec3(30.0, 25.0, 24.0), 16.0, 20.0), 1),
      two(scene, inclusion(Vec3(30.0, 25.0, 24.0), 16.0, 20.0), 2);
  one.play(6.0, 1);
  two.play(6.0, 1);
  REQUIRE(one.reports().size() == two.reports().size());
  for (std::size_t k = 0; k < one.reports().size(); ++k) {
    const MismatchReport &a = one.reports()[k], &b = two.reports()[k];
    REQUIRE(a.level == b.level);
    REQUIRE(a.misfit == b.misfit);
    REQUIRE(a.place == b.place);
    REQUIRE(a.raised == b.raised);
  }
}
