// The filter that learns stiffness: its sensitivities against bodies whose stiffness was changed, what it learns
// against a body with a hidden lump, and what gates, swapped labels and gaps do to it.
#include <Eigen/Eigenvalues>
#include <atomic>
#include <catch2/catch.hpp>

#include "core/admm_simulator.hpp"
#include "core/stiffness_field.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr double kWeightScale = 4.0;

Scene soft_box(int markers = 16) {
  Scene scene = box_scene({6, 6, 4, 10.0}, markers);
  scene.marker_noise = 0.05;
  return scene;
}

std::vector<PadInput> pushed(const Scene& scene, int pad, double depth) {
  std::vector<PadInput> pads(scene.pads.size());
  pads[pad].kind = PadInput::Kind::pose;
  pads[pad].center = scene.pads[pad].center + depth * scene.pads[pad].direction;
  return pads;
}

// A body in equilibrium whose log-stiffness at every node is given.
class HiddenBody {
 public:
  HiddenBody(const Scene& scene, const Eigen::VectorXd& log_stiffness)
      : model_(scene, Element::smoothed, kWeightScale, kQuasiStatic), state_(model_), workspace_(model_, 1) {
    for (std::size_t slot = 0; slot < model_.blocks().domain.size(); ++slot) {
      const int domain = model_.blocks().domain[slot];
      if (domain < 0) continue;
      double sum = 0.0;
      for (int anchor : model_.domains()[domain].anchors) sum += log_stiffness[anchor];
      state_.domains[slot / kLanes].factor[slot % kLanes] =
          std::exp(sum / static_cast<double>(model_.domains()[domain].anchors.size()));
    }
  }

  void settle(const std::vector<PadInput>& pads, int iterations) {
    begin_step(model_, state_, workspace_, pads, kQuasiStatic, 100.0);
    for (int k = 0; k < iterations; ++k) {
      local_stage(model_, state_, workspace_);
      global_stage(model_, state_, workspace_, kQuasiStatic);
    }
  }

  Vec3 moved(const MaterialPoint& point) const {
    return position_of(point, state_.x) - position_of(point, model_.rest());
  }
  // N, of the pads on the tissue.
  std::vector<Vec3> forces() const {
    std::vector<Vec3> forces(model_.scene().pads.size());
    pad_forces(workspace_, forces);
    return forces;
  }
  const Model& model() const { return model_; }
  AdmmState& state() { return state_; }

 private:
  Model model_;
  AdmmState state_;
  AdmmWorkspace workspace_;
};

Eigen::VectorXd lump(const Scene& scene, const Vec3& center, double radius, double log_stiffness) {
  Eigen::VectorXd field = Eigen::VectorXd::Zero(scene.mesh.node_count());
  for (int i = 0; i < scene.mesh.node_count(); ++i)
    if ((scene.mesh.node(i) - center).norm() < radius) field[i] = log_stiffness;
  return field;
}

// Pushes a simulator and the hidden body that it shall follow, as slowly as a hand does.
struct Session {
  Scene scene;
  HiddenBody body;
  AdmmSimulator simulator, open_loop;
  Observation observation;
  StepReport report;

  Session(const Scene& s, const Eigen::VectorXd& field)
      : scene(s), body(s, field), simulator(s, options(), true), open_loop(s, options(), false) {
    observation.resize_for(scene);
  }

  static SimulatorOptions options() {
    SimulatorOptions options;
    options.solver.threads = 1;
    return options;
  }

  // slip: mm by which the pads' nodes are not where the pads are.
  void observe(const std::vector<PadInput>& pads, const Vec3& slip = Vec3::Zero()) {
    std::vector<PadInput> slipped = pads;
    for (PadInput& pad : slipped) pad.center += slip;
    body.settle(slipped, 40);
    observation.pads = pads;
    observation.dt = 0.01;
    for (std::size_t i = 0; i < scene.markers.size(); ++i) {
      observation.markers[i] = scene.markers[i].rest + body.moved(body.model().marker_points()[i]);
      observation.marker_seen[i] = 1;
    }
  }

  void step() {
    report = simulator.step(observation);
    open_loop.step(observation);
  }

  void push_and_release(int pad, double depth) {
    for (int frame = 1; frame <= 140; ++frame) {
      observe(pushed(scene, pad, depth * std::min(1.0, frame / 80.0)));
      step();
    }
    for (int frame = 1; frame <= 30; ++frame) {
      observe(pushed(scene, pad, depth * (1.0 - frame / 30.0)));
      step();
    }
  }

  double target_error(const AdmmSimulator& of) const {
    double sum = 0.0;
    for (std::size_t t = 0; t < scene.targets.size(); ++t)
      sum += (of.target(static_cast<int>(t)).position - scene.targets[t].rest -
              body.moved(body.model().target_points()[t]))
                 .norm();
    return sum / static_cast<double>(scene.targets.size());
  }
};

}  // namespace

TEST_CASE("the field has the variance and the correlation it is asked for", "[stiffness_filter]") {
  const Scene scene = soft_box();
  const RowMatrix field = stiffness_field(scene.mesh.rest, 0.5, 15.0, 1000);
  REQUIRE(field.cols() < field.rows());
  const Eigen::MatrixXd covariance = field * field.transpose();
  for (Eigen::Index i = 0; i < covariance.rows(); i += 7) {
    CHECK(covariance(i, i) <= 0.25 + 1e-12);
    CHECK(covariance(i, i) >= 0.9 * 0.25 - 1e-12);
    for (Eigen::Index k = 0; k < covariance.cols(); k += 5) {
      const double distance = (scene.mesh.rest.row(i) - scene.mesh.rest.row(k)).norm();
      CHECK(covariance(i, k) == Approx(0.25 * std::exp(-0.5 * distance * distance / 225.0)).margin(0.025));
    }
  }
}

TEST_CASE("sensitivities are what changing the stiffness does", "[stiffness_filter]") {
  const Scene scene = soft_box();
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(scene.mesh.node_count());
  const std::vector<PadInput> pads = pushed(scene, 0, 1.2);
  HiddenBody body(scene, nothing);
  body.settle(pads, 1500);
  FilterOptions options;
  StiffnessFilter filter(body.model(), options);
  std::vector<Vec3> markers;
  for (const Marker& marker : scene.markers) markers.push_back(marker.rest);
  const std::vector<std::uint8_t> seen(markers.size(), 1);
  AdmmState observed = body.state();
  for (std::size_t i = 0; i < markers.size(); ++i) markers[i] += body.moved(body.model().marker_points()[i]);
  // Loads below a millimetre teach nothing; the pad moves markers by more.
  double load = 0.0;
  for (const MaterialPoint& point : body.model().marker_points()) load = std::max(load, body.moved(point).norm());
  REQUIRE(load > 1.0);
  for (int frame = 0; frame < 60; ++frame) filter.correct(markers, seen, pads, body.forces(), 0.0, 0.01, observed);
  REQUIRE(filter.sensitivity().norm() > 0.0);

  const RowMatrix field = stiffness_field(scene.mesh.rest, options.stiffness_sd, options.stiffness_length, 128);
  REQUIRE(field.cols() + 1 == filter.coefficients());  // and the stiffness as a whole
  double wrong = 0.0, size = 0.0, wrong_force = 0.0, force_size = 0.0;
  for (Eigen::Index coefficient = 0; coefficient < field.cols(); coefficient += 9) {
    const double step = 0.2;
    HiddenBody changed(scene, step * field.col(coefficient));
    changed.settle(pads, 1500);
    const auto compare = [&](const MaterialPoint& point, Eigen::Index row) {
      const Vec3 slope = (changed.moved(point) - body.moved(point)) / step;
      const Vec3 said = filter.sensitivity().block(row, coefficient, 3, 1);
      wrong += (slope - said).squaredNorm();
      size += slope.squaredNorm();
    };
    for (std::size_t i = 0; i < scene.markers.size(); ++i)
      compare(body.model().marker_points()[i], 3 * static_cast<Eigen::Index>(i));
    for (std::size_t t = 0; t < scene.targets.size(); ++t)
      compare(body.model().target_points()[t], 3 * static_cast<Eigen::Index>(scene.markers.size() + t));
    const auto row = 3 * static_cast<Eigen::Index>(scene.markers.size() + scene.targets.size());
    const Vec3 slope = (changed.forces()[0] - body.forces()[0]) / step,
               said = filter.sensitivity().block<3, 1>(row, coefficient);
    wrong_force += (slope - said).squaredNorm();
    force_size += slope.squaredNorm();
  }
  // The compliance is that at rest, and few of a pad's nodes stand for all.
  CHECK(std::sqrt(wrong / size) < 0.2);
  CHECK(std::sqrt(wrong_force / force_size) < 0.2);
  // Stiffer as a whole: nothing moves, and the pad pushes in proportion.
  const Eigen::VectorXd scale = filter.sensitivity().rightCols(1);
  CHECK(scale.head(3 * static_cast<Eigen::Index>(scene.markers.size() + scene.targets.size())).norm() == 0.0);
  const Vec3 force = body.forces()[0];
  CHECK((scale.segment<3>(scale.size() - 6) - 0.5 * force).norm() < 0.05 * 0.5 * force.norm());
}

TEST_CASE("pushing one side teaches what the other side's push will do", "[stiffness_filter]") {
  const Scene scene = soft_box();
  Session session(scene, lump(scene, Vec3(30, 30, 22), 14.0, 0.9));
  for (double depth : {4.0, 8.0}) session.push_and_release(0, depth);
  for (int frame = 1; frame <= 60; ++frame) {
    session.observe(pushed(scene, 1, 8.0 * std::min(1.0, frame / 50.0)));
    // No marker is seen: whatever is right now was learnt before.
    std::fill(session.observation.marker_seen.begin(), session.observation.marker_seen.end(), std::uint8_t{0});
    session.step();
  }
  REQUIRE(session.target_error(session.open_loop) > 0.05);
  CHECK(session.target_error(session.simulator) < 0.85 * session.target_error(session.open_loop));
  // It is stiffer where the lump is than at a corner of the base.
  int middle = 0, corner = 0;
  for (int i = 0; i < scene.mesh.node_count(); ++i) {
    if ((scene.mesh.node(i) - Vec3(30, 30, 22)).norm() < (scene.mesh.node(middle) - Vec3(30, 30, 22)).norm())
      middle = i;
    if (scene.mesh.node(i).norm() < scene.mesh.node(corner).norm()) corner = i;
  }
  const StiffnessFilter& filter = *session.simulator.stiffness_filter();
  CHECK(filter.log_stiffness(middle) > filter.log_stiffness(corner) + 0.07);
  session.simulator.reset();
  CHECK(filter.log_stiffness(middle) == 0.0);
}

TEST_CASE("a braked step costs nothing of what was learnt", "[stiffness_filter]") {
  const Scene scene = soft_box();
  std::vector<Vec3> places;
  for (const bool braked : {false, true}) {
    Session session(scene, lump(scene, Vec3(30, 30, 22), 14.0, 0.9));
    for (double depth : {4.0, 8.0}) session.push_and_release(0, depth);
    for (int frame = 1; frame <= 120; ++frame) {
      session.observe(pushed(scene, 1, 8.0 * std::min(1.0, frame / 50.0)));
      // No marker is seen: nothing is learnt anew.
      std::fill(session.observation.marker_seen.begin(), session.observation.marker_seen.end(), std::uint8_t{0});
      const std::atomic<std::uint64_t> pulled_for{braked && frame == 30 ? 1u : 0u};
      session.observation.brake = {&pulled_for, 1};
      session.step();
      CHECK(session.report.braked == (braked && frame == 30));
    }
    places.push_back(session.simulator.target(0).position);
    if (braked) CHECK((places.back() - session.open_loop.target(0).position).norm() > 0.05);
  }
  CHECK((places[0] - places[1]).norm() < 0.005);
}

TEST_CASE("a right model stays what it is", "[stiffness_filter]") {
  const Scene scene = soft_box();
  Session session(scene, Eigen::VectorXd::Zero(scene.mesh.node_count()));
  for (int pad : {0, 1}) session.push_and_release(pad, 8.0);
  double largest = 0.0;
  for (int i = 0; i < scene.mesh.node_count(); ++i)
    largest = std::max(largest, std::abs(session.simulator.stiffness_filter()->log_stiffness(i)));
  CHECK(largest < 0.15);
}

TEST_CASE("a measured force tells how stiff the body is as a whole", "[stiffness_filter]") {
  const Scene scene = soft_box();
  const Eigen::VectorXd stiffer = Eigen::VectorXd::Constant(scene.mesh.node_count(), std::log(1.4));
  Session weighed(scene, stiffer), unweighed(scene, stiffer);
  for (int frame = 1; frame <= 140; ++frame) {
    const auto pads = pushed(scene, 0, 8.0 * std::min(1.0, frame / 80.0));
    for (Session* session : {&weighed, &unweighed}) session->observe(pads);
    weighed.observation.pads[0].measured_force = weighed.body.forces()[0];
    weighed.step();
    unweighed.step();
  }
  const Vec3 truth = weighed.body.forces()[0];
  const auto wrong = [&](const Session& session) {
    return (session.simulator.pad_force(0) - truth).norm() / truth.norm();
  };
  INFO("force error " << wrong(unweighed) << " without, " << wrong(weighed) << " with the force measured");
  CHECK(wrong(unweighed) > 0.2);  // markers alone cannot know
  CHECK(wrong(weighed) < 0.05);
  CHECK(weighed.target_error(weighed.simulator) < weighed.target_error(weighed.open_loop) + 0.02);
}

TEST_CASE("a pad that slips on the skin is not taken for stiffness", "[stiffness_filter]") {
  const Scene scene = soft_box();
  Session session(scene, Eigen::VectorXd::Zero(scene.mesh.node_count()));
  const Vec3 slip(0.15, 0.1, 0.0);  // of the push
  for (int frame = 1; frame <= 120; ++frame) {
    const double depth = 8.0 * std::min(1.0, frame / 80.0);
    session.observe(pushed(scene, 0, depth), depth * slip);
    session.step();
  }
  REQUIRE(session.target_error(session.open_loop) > 0.2);
  CHECK(session.target_error(session.simulator) < 0.4 * session.target_error(session.open_loop));
  const StiffnessFilter& filter = *session.simulator.stiffness_filter();
  CHECK((filter.discrepancy().slip(0) - 8.0 * slip).norm() < 0.4 * 8.0 * slip.norm());
}

TEST_CASE("one wild marker is refused and changes nothing", "[stiffness_filter]") {
  const Scene scene = soft_box();
  const Eigen::VectorXd field = lump(scene, Vec3(30, 30, 22), 14.0, 0.5);
  Session clean(scene, field), wild(scene, field);
  for (int frame = 1; frame <= 80; ++frame) {
    for (Session* session : {&clean, &wild}) session->observe(pushed(scene, 0, 6.0 * std::min(1.0, frame / 50.0)));
    if (frame % 3 != 0) wild.observation.markers[frame % 5] += Vec3(9.0, -7.0, 8.0);
    clean.step();
    wild.step();
    if (frame % 3 != 0) REQUIRE(wild.report.markers_used == static_cast<int>(scene.markers.size()) - 1);
  }
  for (int t = 0; t < 3; ++t)
    CHECK((clean.simulator.target(t).position - wild.simulator.target(t).position).norm() < 0.05);
}

TEST_CASE("labels that were taken for each other are recognised", "[stiffness_filter]") {
  const Scene scene = soft_box();
  Session session(scene, Eigen::VectorXd::Zero(scene.mesh.node_count()));
  for (int frame = 1; frame <= 40; ++frame) {
    session.observe(pushed(scene, 0, 5.0 * std::min(1.0, frame / 30.0)));
    if (frame > 20) std::swap(session.observation.markers[1], session.observation.markers[4]);
    session.step();
    CHECK(session.report.markers_swapped == (frame > 20 ? 2 : 0));
    CHECK(session.report.markers_used == static_cast<int>(scene.markers.size()));
    CHECK(session.report.innovation_rms < 0.4);
  }
}

TEST_CASE("covariances are positive, grow with the load and shrink with markers near", "[stiffness_filter]") {
  const Scene scene = soft_box();
  const Eigen::VectorXd right = Eigen::VectorXd::Zero(scene.mesh.node_count());
  Session seen(scene, right), blind(scene, right);
  double before = 0.0;
  for (int frame = 1; frame <= 60; ++frame) {
    for (Session* session : {&seen, &blind}) session->observe(pushed(scene, 0, 6.0 * std::min(1.0, frame / 50.0)));
    std::fill(blind.observation.marker_seen.begin(), blind.observation.marker_seen.end(), std::uint8_t{0});
    seen.step();
    blind.step();
    CHECK(blind.report.markers_used == 0);
    for (int t = 0; t < 3; ++t) {
      const Mat3 covariance = seen.simulator.target(t).covariance;
      CHECK((covariance - covariance.transpose()).norm() < 1e-12);
      CHECK(Eigen::SelfAdjointEigenSolver<Mat3>(covariance).eigenvalues().minCoeff() > 0.0);
      if (frame > 50) CHECK(covariance.trace() < blind.simulator.target(t).covariance.trace());
    }
    if (frame <= 50) CHECK(blind.simulator.target(0).covariance.trace() > before);
    before = blind.simulator.target(0).covariance.trace();
  }
}
