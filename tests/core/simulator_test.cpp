// The simulators admm and kf-admm as whoever steps them sees them.
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <string>
#include <thread>

#include "core/admm_simulator.hpp"
#include "core/static_solve.hpp"
#include "tests/core/newton_twin.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr BoxSize kSmall{3, 2, 2, 10.0};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

SimulatorOptions options_of(const std::string& kind, Scheme scheme = Scheme::per_frame) {
  SimulatorOptions options;
  options.kind = kind;
  options.solver.element = Element::p1;
  options.solver.tolerance = 0.0;
  options.solver.scheme = scheme;
  options.solver.threads = 1;
  return options;
}

// Markers at rest and seen, pads off the skin.
Observation rest_observation(const Scene& scene) {
  Observation observation;
  observation.resize_for(scene);
  for (std::size_t i = 0; i < scene.markers.size(); ++i) observation.markers[i] = scene.markers[i].rest;
  observation.marker_seen.assign(scene.markers.size(), 1);
  return observation;
}

void push(Observation& observation, const Scene& scene, int pad, const Vec3& way) {
  observation.pads[pad].kind = PadInput::Kind::pose;
  observation.pads[pad].center = scene.pads[pad].center + way;
}

double largest_difference(const NodeField& a, const NodeField& b) { return (a - b).rowwise().norm().maxCoeff(); }

int inverted_elements(const Scene& scene, const NodeField& x) {
  TetMesh mesh = scene.mesh;
  mesh.rest = x.leftCols<3>();
  int count = 0;
  for (const Tet& tet : mesh.tets) count += !(signed_volume(mesh, tet) > 0);
  return count;
}

// A run with everything in it: a pad that presses, turns over to its neighbour, leaves; markers that wander and drop
// out.
Observation eventful_frame(const Scene& scene, int frame) {
  std::mt19937 generator(static_cast<unsigned>(1000 + frame));
  Observation observation = rest_observation(scene);
  const Vec3 way(0.0, 0.1 * frame, -0.2 * frame);
  if (frame > 5 && frame < 35) push(observation, scene, 0, way);
  if (frame > 25 && frame < 45) push(observation, scene, 1, 0.3 * way);
  if (frame >= 45) {
    observation.pads[0].kind = PadInput::Kind::force;
    observation.pads[0].force = Vec3(0.0, 0.0, -0.05);
  }
  for (std::size_t i = 0; i < scene.markers.size(); ++i) {
    observation.markers[i] += random_vector(generator);
    observation.marker_seen[i] = frame % 10 == 0 ? 0 : generator() % 4 != 0;
  }
  return observation;
}

std::vector<std::uint64_t> hashes_of(Simulator& simulator, int frames) {
  std::vector<std::uint64_t> hashes;
  for (int frame = 0; frame < frames; ++frame) {
    simulator.step(eventful_frame(simulator.scene(), frame));
    hashes.push_back(simulator.state_hash());
  }
  return hashes;
}

}  // namespace

TEST_CASE("rest stays rest", "[simulator]") {
  const std::string kind = GENERATE("admm", "kf-admm");
  const Scheme scheme = GENERATE(Scheme::per_frame, Scheme::algorithm_1);
  const Scene scene = box_scene(kSmall);
  const auto simulator = make_simulator(scene, options_of(kind, scheme));
  const NodeField rest = simulator->positions();
  const Observation observation = rest_observation(scene);
  StepReport report;
  for (int frame = 0; frame < 1000; ++frame) report = simulator->step(observation);
  CHECK(largest_difference(simulator->positions(), rest) < 1e-12);
  CHECK(report.converged);
  CHECK(report.finite);
  CHECK(report.inverted == 0);
  CHECK(report.markers_used == (kind == "kf-admm" ? 7 : 0));
  for (int t = 0; t < 3; ++t) CHECK((simulator->target(t).position - scene.targets[t].rest).norm() < 1e-12);
  for (int m = 0; m < 7; ++m) CHECK((simulator->marker(m) - scene.markers[m].rest).norm() < 1e-12);
}

TEST_CASE("in time a held push comes to rest where statics is", "[simulator]") {
  Scene scene = box_scene(kSmall);
  scene.gravity = Vec3(0.0, 0.0, -0.5);
  const auto simulator = make_simulator(scene, options_of("admm", GENERATE(Scheme::per_frame, Scheme::algorithm_1)));
  Observation observation = rest_observation(scene);
  push(observation, scene, 0, Vec3(0.5, 0.0, -2.5));
  for (int frame = 0; frame < 1500; ++frame) simulator->step(observation);
  const TwinAnswer twin = solve_by_newton(scene, observation.pads, external_forces(scene, observation.pads), 4);
  CHECK(largest_difference(simulator->positions(), twin.positions) < 1e-4);
  Vec3 reaction = Vec3::Zero();
  for (int node : nodes_of(*scene.mesh.find_surface("A1"))) reaction += twin.reactions[node];
  CHECK((simulator->pad_force(0) - reaction).norm() < 1e-3 * reaction.norm());
  CHECK(simulator->pad_force(1).norm() == 0.0);
}

TEST_CASE("the force branch comes to rest where statics with that force is", "[simulator]") {
  const Scene scene = box_scene(kSmall);
  const auto simulator = make_simulator(scene, options_of("admm"));
  Observation observation = rest_observation(scene);
  observation.pads[1].kind = PadInput::Kind::force;
  observation.pads[1].force = Vec3(0.03, 0.0, -0.2);
  for (int frame = 0; frame < 1500; ++frame) simulator->step(observation);
  const TwinAnswer twin = solve_by_newton(scene, observation.pads, external_forces(scene, observation.pads), 4);
  CHECK(largest_difference(simulator->positions(), twin.positions) < 1e-4);
}

TEST_CASE("a measured time step needs no new factor", "[simulator]") {
  const Scene scene = box_scene(kSmall);
  SimulatorOptions fast = options_of("admm"), slow = fast;
  fast.solver.iterations = slow.solver.iterations = 1500;
  slow.solver.time_step = 2.0 * fast.solver.time_step;
  const auto one = make_simulator(scene, fast), other = make_simulator(scene, slow);
  Observation observation = rest_observation(scene);
  observation.dt = slow.solver.time_step;
  for (int frame = 0; frame < 6; ++frame) {
    push(observation, scene, 0, Vec3(0.0, 0.0, -0.4 * (frame + 1)));
    one->step(observation);
    other->step(observation);
    CHECK(largest_difference(one->positions(), other->positions()) < 1e-6);
  }
}

TEST_CASE("the same frames give the same bits, with one thread, with two, and again", "[simulator]") {
  const std::string kind = GENERATE("admm", "kf-admm");
  const Scheme scheme = GENERATE(Scheme::per_frame, Scheme::algorithm_1);
  const Scene scene = box_scene({4, 3, 2, 10.0});
  SimulatorOptions one = options_of(kind, scheme);
  one.solver.iterations = 4;
  if (GENERATE(false, true)) one.effects = many_effects(scene);
  SimulatorOptions two = one;
  two.solver.threads = 2;
  const auto simulator = make_simulator(scene, one), again = make_simulator(scene, one),
             wide = make_simulator(scene, two);
  const auto hashes = hashes_of(*simulator, 50);
  CHECK(hashes_of(*again, 50) == hashes);
  CHECK(hashes_of(*wide, 50) == hashes);
  simulator->reset();
  CHECK(hashes_of(*simulator, 50) == hashes);
  CHECK(hashes.front() != hashes.back());
}

TEST_CASE("what an unseen marker holds never matters", "[simulator]") {
  const Scene scene = box_scene(kSmall);
  const auto clean = make_simulator(scene, options_of("kf-admm")), dirty = make_simulator(scene, options_of("kf-admm"));
  dirty->reset();
  for (int frame = 0; frame < 20; ++frame) {
    Observation observation = eventful_frame(scene, frame);
    clean->step(observation);
    for (std::size_t i = 0; i < scene.markers.size(); ++i)
      if (!observation.marker_seen[i]) observation.markers[i].setConstant(kNaN);
    const StepReport report = dirty->step(observation);
    CHECK(report.finite);
    REQUIRE(clean->state_hash() == dirty->state_hash());
  }
}

TEST_CASE("a state that is not finite is refused, said and left behind", "[simulator]") {
  const Scene scene = box_scene(kSmall);
  const std::string kind = GENERATE("admm", "kf-admm");
  const auto simulator = make_simulator(scene, options_of(kind));
  Observation observation = rest_observation(scene);
  push(observation, scene, 0, Vec3(0, 0, -2));
  for (int frame = 0; frame < 10; ++frame) simulator->step(observation);
  const NodeField good = simulator->positions();
  Observation poisoned = observation;
  poisoned.pads[0].center.setConstant(kNaN);
  CHECK(!simulator->step(poisoned).finite);
  CHECK(simulator->positions() == good);
  StepReport report;
  for (int frame = 0; frame < 300; ++frame) report = simulator->step(observation);
  CHECK(report.finite);
  if (kind == "admm") CHECK(report.converged);  // closed loop, markers at rest and a pad that pushes disagree for ever
  CHECK(simulator->pad_force(0).z() < 0.0);
}

TEST_CASE("a pad that jumps is ramped and arrives, and nothing stays inverted", "[simulator]") {
  const Scene scene = box_scene({4, 3, 5, 10.0});
  const auto simulator = make_simulator(scene, options_of("admm"));
  Observation observation = rest_observation(scene);
  push(observation, scene, 0, Vec3(0, 0, -40.0));
  CHECK(simulator->step(observation).pad_ramp == Approx(37.0));
  for (int frame = 0; frame < 30; ++frame) REQUIRE(simulator->step(observation).finite);
  push(observation, scene, 0, Vec3(0, 0, -5.0));
  StepReport report;
  for (int frame = 0; frame < 600; ++frame) {
    report = simulator->step(observation);
    REQUIRE(report.finite);
  }
  CHECK(report.pad_ramp == 0.0);
  CHECK(report.converged);
  CHECK(report.inverted == 0);
  CHECK(inverted_elements(scene, simulator->positions()) == 0);
}

TEST_CASE("a braked step gives no answer, and goes on from the last one as if it had not begun", "[simulator]") {
  const Scene scene = box_scene({4, 3, 5, 10.0});
  const std::string kind = GENERATE("admm", "kf-admm");
  std::atomic<std::uint64_t> pulled_for{0};
  const auto run = [&](bool from_the_start) {
    SimulatorOptions options = options_of(kind);
    options.solver.iterations = from_the_start ? 10 : 100000;  // of the braked step: no end by itself
    const auto simulator = make_simulator(scene, options);
    Observation observation = rest_observation(scene);
    push(observation, scene, 0, Vec3(0, 0, -2.0));
    observation.max_iterations = 10;
    for (int frame = 0; frame < 20; ++frame) REQUIRE(simulator->step(observation).finite);
    const NodeField before = simulator->positions();

    push(observation, scene, 0, Vec3(0, 0, -4.0));
    observation.max_iterations = 0;
    observation.brake = {&pulled_for, 7};
    pulled_for = from_the_start ? 7 : 0;
    std::thread other([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      pulled_for = 7;
    });
    const StepReport braked = simulator->step(observation);
    other.join();
    CHECK(braked.braked);
    CHECK_FALSE(braked.finite);
    CHECK((braked.iterations == 0) == from_the_start);
    CHECK(simulator->positions() == before);

    observation.max_iterations = 10;
    observation.brake.step = 8;  // pulled for an earlier one
    for (int frame = 0; frame < 20; ++frame) REQUIRE(simulator->step(observation).finite);
    return simulator->state_hash();
  };
  CHECK(run(true) == run(false));
}

TEST_CASE("fewer iterations are taken where a step is allowed fewer", "[simulator]") {
  const Scene scene = box_scene(kSmall);
  const auto simulator = make_simulator(scene, options_of("kf-admm"));
  Observation observation = rest_observation(scene);
  CHECK(simulator->step(observation).iterations == 10);
  observation.max_iterations = 3;
  CHECK(simulator->step(observation).iterations == 3);
  observation.max_iterations = 30;
  CHECK(simulator->step(observation).iterations == 10);
}

TEST_CASE("an inverted body recovers", "[simulator]") {
  const Scene scene = box_scene(kSmall);
  const Model model(scene, Element::p1, 4.0, 0.01);
  AdmmState state(model);
  AdmmWorkspace workspace(model, 1);
  std::mt19937 generator(51);
  for (int node : model.system().free_nodes())
    state.x.row(node).head<3>() += 12.0 * random_vector(generator).transpose();
  state.x_previous = state.x;
  REQUIRE(inverted_elements(scene, state.x) > 5);
  const std::vector<PadInput> pads(2);
  for (int frame = 0; frame < 800; ++frame) {
    begin_step(model, state, workspace, pads, 0.01, 3.0);
    state.x_previous = state.x;
    for (int k = 0; k < 10; ++k) {
      local_stage(model, state, workspace);
      global_stage(model, state, workspace, 0.01);
    }
  }
  CHECK(inverted_elements(scene, state.x) == 0);
  CHECK(largest_difference(state.x, model.rest()) < 1e-3);
}

TEST_CASE("another time step keeps the state", "[simulator]") {
  const Scene scene = box_scene(kSmall);
  const auto simulator = make_simulator(scene, options_of(GENERATE("admm", "kf-admm")));
  hashes_of(*simulator, 20);
  const std::uint64_t before = simulator->state_hash();
  simulator->set_time_step(0.004);
  CHECK(simulator->time_step() == 0.004);
  CHECK(simulator->state_hash() == before);
  Observation observation = rest_observation(scene);
  observation.dt = 0.004;
  for (int frame = 0; frame < 1500; ++frame) REQUIRE(simulator->step(observation).finite);
  CHECK((simulator->target(0).position - scene.targets[0].rest).norm() < 1e-3);
}

TEST_CASE("the filter pulls the model to markers that disagree with it", "[simulator]") {
  const Scene scene = box_scene(kSmall);
  const auto open = make_simulator(scene, options_of("admm")), closed = make_simulator(scene, options_of("kf-admm"));
  Observation observation = rest_observation(scene);
  // A uniform shear that no pad explains.
  const auto sheared = [](const Vec3& p) { return Vec3(p.x() + 0.1 * p.z(), p.y(), p.z()); };
  for (std::size_t i = 0; i < scene.markers.size(); ++i) observation.markers[i] = sheared(scene.markers[i].rest);
  double error_open = 0.0, error_closed = 0.0;
  for (int frame = 0; frame < 300; ++frame) {
    open->step(observation);
    closed->step(observation);
  }
  for (int t = 0; t < 3; ++t) {
    error_open += (open->target(t).position - sheared(scene.targets[t].rest)).norm();
    error_closed += (closed->target(t).position - sheared(scene.targets[t].rest)).norm();
    CHECK(open->target(t).covariance == Mat3::Zero());
    CHECK(closed->target(t).covariance(0, 0) > 0.0);
  }
  CHECK(error_closed < 0.6 * error_open);
}

TEST_CASE("a scene without markers, pads and targets is simulated, too", "[simulator]") {
  Scene scene = box_scene({2, 2, 1, 10.0}, 0);
  scene.pads.clear();
  scene.targets.clear();
  scene.gravity = Vec3(0, 0, -1);
  const auto open = make_simulator(scene, options_of("admm")), closed = make_simulator(scene, options_of("kf-admm"));
  const Observation observation = rest_observation(scene);
  for (int frame = 0; frame < 20; ++frame) {
    open->step(observation);
    CHECK(closed->step(observation).finite);
    REQUIRE(closed->positions() == open->positions());
  }
}

TEST_CASE("simulators are made by name, and bad scenes are refused in words", "[simulator]") {
  CHECK(simulator_names().size() == 5);
  for (const std::string_view name : simulator_names())
    CHECK_NOTHROW(make_simulator(box_scene({2, 2, 1, 10.0}), options_of(std::string(name))));
  const auto refusal = [](const Scene& scene, const std::string& kind) -> std::string {
    try {
      make_simulator(scene, options_of(kind));
    } catch (const ModelError& error) {
      return error.what();
    }
    return "";
  };
  const Scene good = box_scene(kSmall);
  CHECK(refusal(good, "sofa").find("sofa") != std::string::npos);
  Scene bad = good;
  bad.markers[2].rest += Vec3(0, 0, 90);
  CHECK(refusal(bad, "admm").find("marker m2") != std::string::npos);
  bad = good;
  bad.targets[1].rest.z() = -3.0;
  CHECK(refusal(bad, "admm").find("target T1") != std::string::npos);
  bad = good;
  bad.pads[0].surface = "A9";
  CHECK(refusal(bad, "admm").find("A9") != std::string::npos);
  bad = good;
  std::swap(bad.mesh.tets[4][0], bad.mesh.tets[4][1]);
  CHECK(refusal(bad, "admm").find("tetrahedron 4") != std::string::npos);
  bad = good;
  bad.material.poissons_ratio = 0.5;
  CHECK(refusal(bad, "admm").find("poissons_ratio") != std::string::npos);
}
