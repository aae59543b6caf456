// `admm`, the open-loop simulator, and `kf-admm`, the same with a marker filter: Algorithm 1.
#pragma once

#include <memory>
#include <optional>

#include "core/admm.hpp"
#include "core/element_error.hpp"
#include "core/learnt_shift.hpp"
#include "core/marker_filter.hpp"
#include "core/marker_history.hpp"
#include "core/mismatch_alarm.hpp"
#include "core/mismatch_place.hpp"
#include "core/simulator.hpp"
#include "core/stiffness_filter.hpp"

namespace tissued::core {

class AdmmSimulator final : public Simulator {
 public:
  // closed_loop: with a filter. Throws ModelError.
  AdmmSimulator(const Scene& scene, const SimulatorOptions& options, bool closed_loop);

  const Scene& scene() const override { return model_->scene(); }
  void reset() override;
  StepReport step(const Observation& observation) noexcept override;
  void set_time_step(double time_step) override;
  double time_step() const override { return time_step_; }
  const NodeField& positions() const override { return state_->x; }
  TargetEstimate target(int index) const noexcept override;
  Vec3 marker(int index) const noexcept override;
  Vec3 pad_force(int index) const noexcept override { return pad_forces_[static_cast<std::size_t>(index)]; }
  Vec3 probe_force(int index) const noexcept override { return probe_forces_[static_cast<std::size_t>(index)]; }
  std::uint64_t state_hash() const noexcept override;

  const Model& model() const { return *model_; }
  const MarkerFilter* filter() const { return filter_ ? &*filter_ : nullptr; }
  const StiffnessFilter* stiffness_filter() const { return stiffness_filter_ ? &*stiffness_filter_ : nullptr; }
  const MismatchAlarm* alarm() const { return watch_ ? &watch_->alarm : nullptr; }

 private:
  void build(const Scene& scene, double time_step);
  void read_pad_forces(std::span<const PadInput> pads);
  int steps_per_frame() const;
  void settle();
  double iterate_once(std::span<const PadInput> pads, double dt, double effect_time, bool anew,
                      LocalStepResult* local = nullptr);
  void solve(const Observation& observation, StepReport& report);
  void hold_last_finite();
  void iterate(const Observation& observation, double dt, int iterations, StepReport& report);
  void bring_forward(const Observation& observation, StepReport& report);
  void correct(const Observation& observation, double dt, int frames, StepReport& report);
  void start_watch();
  void watch(const Observation& observation, double dt, StepReport& report);
  bool state_is_finite() const;

  // Whether the markers contradict what is assumed.
  struct Watch {
    MismatchAlarm alarm;
    LearntShift learnt;
    MismatchPlace place;
    ElementError error;
    std::vector<Vec3> misfit, elements;  // (markers) mm
  };

  SimulatorOptions options_;
  bool closed_loop_;
  double time_step_ = 0.0;
  std::unique_ptr<Enrichment> enrichment_;  // null: no effects
  std::unique_ptr<Model> model_;
  std::optional<EffectForces> effects_;
  int effects_every_ = 1;  // iterations
  std::optional<AdmmState> state_;
  std::optional<AdmmWorkspace> workspace_;
  std::optional<ModalBasis> basis_;                  // does not depend on the time step
  std::optional<MarkerFilter> filter_;               // presets paper and force
  std::optional<StiffnessFilter> stiffness_filter_;  // preset standard
  std::optional<Watch> watch_;                       // likewise
  std::optional<MarkerHistory> history_;
  std::vector<Vec3> simulated_, markers_now_;  // (markers) mm: simulated; seen, brought forward to the newest pads
  std::vector<std::uint8_t> marker_seen_;      // (markers), as observed; none where they came too late
  NodeField last_finite_;
  std::vector<PadInput> lifted_;  // (pads) none touches
  std::vector<Vec3> pad_forces_, probe_forces_;
};

}  // namespace tissued::core
