// Times time steps of `pbd` on bundles while the first pad goes 20 mm in and out: by the clock, and in processor time,
// which other work on the machine hardly touches.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <vector>

#include "config/bundle.hpp"
#include "core/pbd_simulator.hpp"
#include "daemon/scene_loader.hpp"
#include "tests/benchmark/stopwatch.hpp"

namespace {

using namespace tissued;

double processor_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void print(const char* clock, const benchmark::Times& t) {
  std::printf("  %-9s  p50 %6.2f  p99 %6.2f  max %6.2f ms\n", clock, t.p50, t.p99, t.max);
}

void push_in_and_out(const core::Scene& scene) {
  constexpr int kSteps = 1000;
  core::SimulatorOptions options;
  core::PbdSimulator simulator(scene, options);
  core::Observation observation;
  observation.resize_for(scene);
  observation.dt = options.pbd.time_step;
  observation.pads[0].kind = core::PadInput::Kind::pose;
  std::vector<double> processor;
  int frame = 0;
  const benchmark::Times wall = benchmark::times_of(kSteps, [&] {
    const double depth = 10.0 * (1.0 - std::cos(0.02 * frame++));
    observation.pads[0].center = scene.pads[0].center + depth * scene.pads[0].direction;
    const double begin = processor_ms();
    simulator.step(observation);
    processor.push_back(processor_ms() - begin);
  });
  std::sort(processor.begin(), processor.end());
  std::printf("%s: %d particles in %d clusters (%zu memberships), a time step of %d x %d iterations\n",
              scene.name.c_str(), simulator.model().lattice.count(), simulator.model().clusters.count(),
              simulator.model().clusters.particle.size(), options.pbd.substeps, options.pbd.iterations);
  print("clock", wall);
  print("processor", {processor[kSteps / 2], processor[kSteps * 99 / 100], processor.back()});
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) push_in_and_out(daemon::load_scene(config::load_bundle(argv[i])));
  return 0;
}
