// A step allocates nothing: every malloc and operator new of the process is counted while it runs.
#include <dlfcn.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <new>

#include "core/simulator.hpp"
#include "tests/core/test_bodies.hpp"

namespace {

std::atomic<long> allocations{0};

}  // namespace

// Interposed before the C library's, which operator new and Eigen end in. Not calloc: dlsym itself may need it.
extern "C" void* malloc(std::size_t size) noexcept {
  using Malloc = void* (*)(std::size_t);
  static const Malloc next = reinterpret_cast<Malloc>(dlsym(RTLD_NEXT, "malloc"));
  allocations.fetch_add(1, std::memory_order_relaxed);
  return next(size);
}

extern "C" int posix_memalign(void** out, std::size_t alignment, std::size_t size) noexcept {
  using Align = int (*)(void**, std::size_t, std::size_t);
  static const Align next = reinterpret_cast<Align>(dlsym(RTLD_NEXT, "posix_memalign"));
  allocations.fetch_add(1, std::memory_order_relaxed);
  return next(out, alignment, size);
}

extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  using Align = void* (*)(std::size_t, std::size_t);
  static const Align next = reinterpret_cast<Align>(dlsym(RTLD_NEXT, "aligned_alloc"));
  allocations.fetch_add(1, std::memory_order_relaxed);
  return next(alignment, size);
}

extern "C" void* realloc(void* old, std::size_t size) noexcept {
  using Realloc = void* (*)(void*, std::size_t);
  static const Realloc next = reinterpret_cast<Realloc>(dlsym(RTLD_NEXT, "realloc"));
  allocations.fetch_add(1, std::memory_order_relaxed);
  return next(old, size);
}

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("the count counts", "[allocation]") {
  const long before = allocations;
  int* volatile kept = new int(3);  // volatile: or the pair is optimised away
  delete kept;
  void* aligned = ::operator new (64, std::align_val_t{64});
  ::operator delete (aligned, std::align_val_t{64});
  const Eigen::VectorXd vector = Eigen::VectorXd::Zero(100);
  CHECK(vector.sum() == 0.0);
  CHECK(allocations - before >= 3);
}

namespace {

// Pads of some 60 nodes each and 40 markers: matrices large enough for Eigen's blocked kernels.
Scene large_scene() {
  Scene scene = box_scene({14, 7, 2, 5.0}, 40);
  scene.probes.push_back({"probe", {Vec3::Zero(), Vec3(6.0, 4.0, 10.0), 2.0}, 0.2});
  REQUIRE(nodes_of(*scene.mesh.find_surface("A1")).size() > 48);
  return scene;
}

// Pads, markers and a probe that come, go and move, forty frames long. In how many of them the probe touched.
int check_steps(const Scene& scene, const SimulatorOptions& options) {
  const auto simulator = make_simulator(scene, options);
  Observation observation;
  observation.resize_for(scene);
  std::mt19937 generator(61);
  long counted = 0;
  int touched = 0;
  constexpr int kWarmUp = 5;
  for (int frame = 0; frame < 40; ++frame) {
    CAPTURE(options.kind, static_cast<int>(options.solver.scheme), options.effects.size(), frame);
    for (std::size_t i = 0; i < scene.markers.size(); ++i) {
      observation.markers[i] = scene.markers[i].rest + 0.5 * random_vector(generator);
      observation.marker_seen[i] = frame % 9 == 8 ? 0 : generator() % 3 != 0;
    }
    for (std::size_t p = 0; p < 2; ++p) {
      observation.pads[p].kind = static_cast<PadInput::Kind>((static_cast<std::size_t>(frame) / (2 + p)) % 3);
      observation.pads[p].center = scene.pads[p].center + Vec3(0, 0, -0.5);
      observation.pads[p].force = Vec3(0, 0, -0.01);
    }
    // It comes down, slides and leaves; at times it is not seen.
    observation.probes[0].seen = frame % 11 != 10;
    observation.probes[0].tissue_T_probe.translation = Vec3(25.0 + frame, 17.0, 20.5 - 3.0 * std::sin(0.08 * frame));
    observation.dt = frame % 6 == 5 ? 0.02 : 0.01;
    const long before = allocations;
    const StepReport report = simulator->step(observation);
    touched += report.contacts > 0 ? 1 : 0;
    const double read = simulator->target(1).position.x() + simulator->marker(2).y() + simulator->pad_force(0).z() +
                        simulator->probe_force(0).z();
    const std::uint64_t hash = simulator->state_hash();
    if (frame >= kWarmUp) counted += allocations - before;
    REQUIRE(report.finite);
    REQUIRE(std::isfinite(read));
    REQUIRE(hash != 0);
  }
  const long before = allocations;
  simulator->reset();
  CHECK(allocations - before == 0);
  CHECK(counted == 0);
  return touched;
}

}  // namespace

TEST_CASE("no step allocates, whatever pads, probes and markers do", "[allocation]") {
  const std::string kind = GENERATE("admm", "kf-admm");
  const Scheme scheme = GENERATE(Scheme::per_frame, Scheme::algorithm_1);
  const int threads = GENERATE(1, 2);
  const Scene scene = large_scene();
  SimulatorOptions options;
  options.kind = kind;
  options.solver.scheme = scheme;
  options.solver.threads = threads;
  options.solver.iterations = 3;
  options.filter.modes = 60;
  options.alarm.enabled = true;
  if (GENERATE(false, true)) options.effects = many_effects(scene);
  CHECK(check_steps(scene, options) > 5);
}

TEST_CASE("no step of particles or of a rigid body allocates", "[allocation]") {
  const Scene scene = large_scene();
  SimulatorOptions options;
  options.kind = GENERATE("pbd", "rigid");
  options.rigid.follow = RigidOptions::Follow::markers;
  options.pbd.readout = GENERATE(PbdReadout::blend, PbdReadout::nearest);
  const int touched = check_steps(scene, options);
  CHECK((options.kind == "rigid" || touched > 5));
}
