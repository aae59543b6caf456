#include <catch2/catch.hpp>

#include "core/diagnosis/load_path.hpp"
#include "tests/core/diagnosis/twin_session.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("a path's way back has the poses of its way there", "[diagnosis]") {
  const Scene scene = box_scene({});
  const RecordedTrial trial = push_trial(scene, "t", {0}, 9.5, 12.0);
  const LoadPath path(trial, scene, 2.0);
  // At rest, 2, 4, 6, 8 and 9.5 mm.
  CHECK(path.pose_count() == 6);
  CHECK(path.keys().size() > 12);
  CHECK(path.peak_load() == Approx(9.5));
  for (const LoadKey& key : path.keys()) {
    const double push = (key.pads[0].center - scene.pads[0].center).norm();
    CHECK(key.load == Approx(push).margin(1e-9));
    CHECK(key.pads[1].kind == PadInput::Kind::absent);
  }
}

TEST_CASE("frames that lie on the levels of keys are keys", "[diagnosis]") {
  const Scene scene = box_scene({});
  const LoadPath path(push_trial(scene, "t", {0}, 10.0, 10.0), scene, 2.0);
  CHECK(path.pose_count() == 6);
  for (std::size_t k = 1; k < path.keys().size(); ++k)
    CHECK(std::abs(path.keys()[k].load - path.keys()[k - 1].load) < 2.0 + 1e-9);
}

TEST_CASE("answers between keys are those of a smooth course, and kinks stay kinks", "[diagnosis]") {
  const Scene scene = box_scene({});
  const RecordedTrial trial = push_trial(scene, "t", {0}, 10.0, 10.0);
  const LoadPath path(trial, scene, 2.0);
  // A course that bends with the load, as a force does.
  const auto course = [&](double time) {
    const double load = path.load(time);
    return load + 0.03 * load * load;
  };
  double worst = 0.0;
  for (double time : trial.time) {
    const PathPlace place = path.place(time);
    double sum = 0.0, weights = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      sum += place.weights[k] * course(path.keys()[static_cast<std::size_t>(place.keys[k])].time);
      weights += place.weights[k];
    }
    CHECK(weights == Approx(1.0));
    worst = std::max(worst, std::abs(sum - course(time)));
  }
  CHECK(worst < 0.03);  // of 13; a straight line between keys is 0.03 off, a kink smoothed over 0.3
}

TEST_CASE("before and after a trial its first and last answers hold", "[diagnosis]") {
  const Scene scene = box_scene({});
  const RecordedTrial trial = push_trial(scene, "t", {0}, 4.0, 10.0);
  const LoadPath path(trial, scene, 2.0);
  const auto weight_of = [&path](double time, int key) {
    const PathPlace place = path.place(time);
    double sum = 0.0;
    for (std::size_t k = 0; k < place.keys.size(); ++k)
      if (place.keys[k] == key) sum += place.weights[k];
    return sum;
  };
  CHECK(weight_of(-1.0, 0) == 1.0);
  CHECK(weight_of(1e3, static_cast<int>(path.keys().size()) - 1) == 1.0);
}
