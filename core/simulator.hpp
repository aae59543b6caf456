// One interface for every simulator: the daemon, the player and the studies know no other.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/effects/effect_setting.hpp"
#include "core/fem_mesh.hpp"
#include "core/fem_time_scheme.hpp"
#include "core/mismatch_report.hpp"
#include "core/pad_input.hpp"
#include "core/pbd_options.hpp"
#include "core/rigid_options.hpp"
#include "core/scene.hpp"
#include "core/strain_domains.hpp"
#include "core/types.hpp"

namespace tissued::core {

// How Algorithm 1 counts: `algorithm_1` as printed (one ADMM iteration and one filter update per n; n is both iteration
// and time step, so a frame's time is shared out over its iterations), `per_frame` (several iterations at fixed
// x-tilde, one filter update per tracker frame).
enum class Scheme { per_frame, algorithm_1 };

// What the filter takes the model's error for. `paper`: white noise on every node, Q = 3I, R = 0.01 I. `force`: white
// body forces. `standard`: the tissue's stiffness, a smooth field that is learnt, and a smooth remainder.
enum class NoisePreset { paper, force, standard };

struct SolverOptions {
  Element element = Element::smoothed;
  Scheme scheme = Scheme::per_frame;
  int iterations = 10;         // ADMM iterations a step at most (of algorithm-1: iterations a frame)
  double tolerance = 1e-5;     // mm; stop earlier when the residuals fall below it; 0: always all iterations
  double time_step = 0.01;     // s, nominal: what the global step is factored for
  double weight_scale = 16.0;  // ADMM weights w_i^2 = weight_scale stiffness_i V_i; 1 cycles on large pushes
  int threads = 0;             // of the parallel loops; 0: chosen by the size of the mesh
};

struct FilterOptions {
  NoisePreset preset = NoisePreset::standard;
  double process_noise = 0.0;      // of the presets paper and force, mm^2; 0: the preset's own size
  double measurement_noise = 0.0;  // mm, standard deviation per axis; 0: the preset's own (paper: 0.1)
  int modes = 0;              // of the presets paper and force: lowest kept; 0: all up to 1200 free nodes, else 300
  double stiffness_sd = 0.5;  // of the natural logarithm of the stiffness, before anything is learnt
  double stiffness_length = 12.0;  // mm, over which stiffness varies
  double slip = 0.15;              // of the load: standard deviation of a pad's slip on the skin, per axis
  double discrepancy = 0.015;      // of the load: standard deviation of what neither explains
};

struct FemSimulatorOptions {
  FemElement element = FemElement::p2;
  std::optional<TimeScheme> dynamics;  // none: quasi-static
  RayleighDamping damping;             // of the dynamics
};

// The alarm that the assumed physics does not explain the markers: see core/mismatch_alarm.hpp.
struct AlarmOptions {
  bool enabled = false;       // building it takes quadratic elements; tissued's configuration says otherwise
  double model_error = 0.01;  // of the load: standard deviation per axis of what a right model may miss at a marker
};

struct SimulatorOptions {
  std::string kind = "kf-admm";  // kf-admm | admm | fem | pbd | rigid
  SolverOptions solver;          // of fem: tolerance, time_step and threads
  FilterOptions filter;
  AlarmOptions alarm;  // of kf-admm with the preset standard
  FemSimulatorOptions fem;
  PbdOptions pbd;
  RigidOptions rigid;
  std::vector<EffectSetting> effects;  // physics beyond the scene's; pbd and rigid have none and refuse them
};

// Whether the simulator looks at Observation::markers: the others run in open loop.
bool reads_markers(const SimulatorOptions& options);

// By which another thread ends a step that takes too long. A step that began after it was pulled goes on.
struct StepBrake {
  const std::atomic<std::uint64_t>* pulled_for = nullptr;  // number of a step; null: nobody can
  std::uint64_t step = 0;                                  // number of this one, above 0
  bool pulled() const noexcept { return pulled_for != nullptr && pulled_for->load(std::memory_order_relaxed) == step; }
};

// One tracker frame in tissue coordinates, sized to the scene by the caller: entry i belongs to pads[i], probes[i],
// markers[i].
struct Observation {
  double dt = 0.01;                       // s, measured, since the last step
  std::vector<PadInput> pads;             // (pads)
  std::vector<ProbeInput> probes;         // (probes)
  std::vector<Vec3> markers;              // (markers) mm, tissue; bias of placement removed (RestCalibration)
  std::vector<std::uint8_t> marker_seen;  // (markers) 0: not seen in this frame
  double marker_age = 0.0;                // s by which the markers are older than the pads
  double marker_place_sd = 0.0;           // mm per axis, to which the markers' places at rest are known
  int max_iterations = 0;                 // of this step, below those of the options; 0: those. Of ADMM per frame
  StepBrake brake;                        // of ADMM

  void resize_for(const Scene& scene) {
    pads.assign(scene.pads.size(), PadInput{});
    probes.assign(scene.probes.size(), ProbeInput{});
    markers.assign(scene.markers.size(), Vec3::Zero());
    marker_seen.assign(scene.markers.size(), 0);
  }
};

struct StepReport {
  int iterations = 0;
  double primal_residual = 0.0;  // mm; largest |Dx - z| of an element times its edge length
  double dual_residual = 0.0;    // mm; largest move of a node, of pbd a particle, in the last iteration (of fem: in the
                                 // last correction)
  bool converged = false;        // both, and penetration, below 0.1 mm, or below the tolerance where that is more
  bool finite = true;            // false: the state was not finite; it holds the last finite one
  bool braked = false;           // the step was ended before it was done, and is not finite, either
  int inverted = 0;              // elements with det(Dx) <= 0 when the step's last iteration began
  int markers_used = 0;          // 0 in open loop
  int markers_swapped = 0;       // of them: labels recognised as taken for each other
  int markers_too_late = 0;      // seen longer ago than the simulation remembers; not used
  double innovation_rms = 0.0;   // mm per axis, of the markers used, before the correction
  double pad_ramp = 0.0;         // mm by which a pad or probe is ahead of the simulated one: its jump is ramped
  int contacts = 0;              // places of the skin that probes press
  double penetration = 0.0;      // mm, of the skin into a probe, at most
  MismatchReport mismatch;
};

struct TargetEstimate {
  Vec3 position;                   // mm, tissue
  Mat3 covariance = Mat3::Zero();  // mm^2; zero in open loop: nothing is claimed
};

class Simulator {
 public:
  virtual ~Simulator() = default;
  virtual const Scene& scene() const = 0;
  // Back to rest. Allocates nothing.
  virtual void reset() = 0;
  // One tracker frame. Never throws; never allocates after the first call, but for fem, which is no simulator for the
  // loop. What went wrong is in the report: a probe's pose that is not sound leaves all as it was, and is not finite.
  virtual StepReport step(const Observation& observation) noexcept = 0;
  // Factors again for another nominal time step (a tracker that changed its rate). May allocate; keeps the state.
  virtual void set_time_step(double time_step) = 0;
  virtual double time_step() const = 0;

  virtual const NodeField& positions() const = 0;  // (n x 4) mm, tissue
  virtual TargetEstimate target(int index) const noexcept = 0;
  virtual Vec3 marker(int index) const noexcept = 0;     // mm, tissue; the model's, not the measured one
  virtual Vec3 pad_force(int index) const noexcept = 0;  // N, of the pad on the tissue; zero when absent
  // N, of the probe on the tissue; the probe feels the opposite. Zero when it does not touch.
  virtual Vec3 probe_force(int index) const noexcept = 0;
  // FNV-1a over the bits of the state: equal hashes prove an equal run.
  virtual std::uint64_t state_hash() const noexcept = 0;
};

// Throws ModelError where scene and options do not fit.
std::unique_ptr<Simulator> make_simulator(const Scene& scene, const SimulatorOptions& options);
// Names that make_simulator knows.
std::span<const std::string_view> simulator_names();

}  // namespace tissued::core
