// `pbd`: position-based dynamics with region-based shape matching, after Tagliabue et al. 2019, section 2.1.
#pragma once

#include "core/particle_contact.hpp"
#include "core/pbd_model.hpp"
#include "core/self_collision.hpp"
#include "core/simulator.hpp"

namespace tissued::core {

// What changes.
struct PbdState {
  explicit PbdState(const PbdModel& model);

  NodeField x;  // (particles x 4) mm, tissue
  NodeField v;  // (particles x 4) mm/s
  ClusterState clusters;
  double owed = 0.0;               // s of measured time that no substep has covered yet
  std::vector<ProbeInput> probes;  // (probes) as the last substep left them
};

class PbdSimulator final : public Simulator {
 public:
  // Throws ModelError.
  PbdSimulator(const Scene& scene, const SimulatorOptions& options);

  const Scene& scene() const override { return model_.scene; }
  void reset() override;
  // As many substeps as the measured time asks for; what is left is kept for the next frame. Of a gap longer than five
  // time steps only these are run. Pads and probes reach the frame's pose with its last substep and are evenly on their
  // way before. Inputs that are not finite change nothing, nor do those with a probe that is not sound: the report says
  // so.
  StepReport step(const Observation& observation) noexcept override;
  // The frame's nominal period; what a substep is says PbdOptions alone.
  void set_time_step(double time_step) override { time_step_ = time_step; }
  double time_step() const override { return time_step_; }
  const NodeField& positions() const override { return positions_; }
  TargetEstimate target(int index) const noexcept override;
  Vec3 marker(int index) const noexcept override;
  // Zero: what constraints correct by depends on the time step and the number of iterations, and is no force.
  Vec3 pad_force(int) const noexcept override { return Vec3::Zero(); }
  Vec3 probe_force(int) const noexcept override { return Vec3::Zero(); }
  std::uint64_t state_hash() const noexcept override;

  const PbdModel& model() const { return model_; }
  const PbdState& state() const { return state_; }

 private:
  int substeps_due(double dt);
  void take_pads(std::span<const PadInput> pads);
  void substep(const Observation& observation, double share, StepReport& report);
  void predict(std::span<const PadInput> pads);
  void move_pads(std::span<const PadInput> pads, double share);
  void move_probes(std::span<const ProbeInput> probes, double share);
  int iterate();
  void settle();
  bool state_is_finite() const;
  void hold_last_finite();
  void publish();

  PbdModel model_;
  PbdState state_;
  double time_step_;
  NodeField hanging_;                      // (particles x 4) mm, under the body's own weight
  NodeField last_finite_;                  // (particles x 4) mm
  NodeField before_;                       // (particles x 4) mm, when the substep's last iteration began
  NodeField start_;                        // (particles x 4) mm, when the substep began
  std::vector<double> mobility_;           // (particles) 0 where held now, else 1
  std::vector<int> pad_of_;                // (particles) the pad that holds it, or -1
  std::vector<ParticleContact> contacts_;  // (probes)
  std::vector<PoseChange> pose_changes_;   // (probes) in the substep
  std::optional<SelfCollision> self_collision_;
  NodeField positions_;  // (nodes x 4) mm, tissue
};

}  // namespace tissued::core
