// `fem`: finite elements, open loop, solved to the end in every frame. Not made for the loop: a frame takes as long as
// it takes.
#pragma once

#include <optional>

#include "core/fem_dynamics.hpp"
#include "core/fem_probe_contact.hpp"
#include "core/simulator.hpp"

namespace tissued::core {

class FemSimulator final : public Simulator {
 public:
  // Throws ModelError.
  FemSimulator(const Scene& scene, const SimulatorOptions& options);

  const Scene& scene() const override { return model_.scene(); }
  void reset() override;
  // Where a frame's loads cannot be reached, quasi-static: goes as far as it can, pad_ramp says how far is left;
  // dynamic: stays where it was. Not converged then.
  StepReport step(const Observation& observation) noexcept override;
  void set_time_step(double time_step) override { time_step_ = time_step; }
  double time_step() const override { return time_step_; }
  const NodeField& positions() const override { return positions_; }  // of the mesh's nodes
  TargetEstimate target(int index) const noexcept override;
  Vec3 marker(int index) const noexcept override;
  Vec3 pad_force(int index) const noexcept override { return pad_forces_[static_cast<std::size_t>(index)]; }
  Vec3 probe_force(int index) const noexcept override { return probe_forces_[static_cast<std::size_t>(index)]; }
  std::uint64_t state_hash() const noexcept override;

 private:
  FemReport advance(const Observation& observation, double dt);
  FemReport solve_contact(const Observation& observation, double dt);
  FemReport press(const Observation& observation, double& ahead);
  void publish(std::span<const PadInput> pads);

  FemProbeContact* contact_ = nullptr;  // one of the model's terms; null: no probes
  FemModel model_;
  FemEquilibrium equilibrium_;
  std::optional<FemDynamics> dynamics_;
  FemControl control_;
  FemState state_;
  Eigen::VectorXd rest_;
  double time_step_;
  NodeField positions_;
  std::vector<Vec3> pad_forces_, probe_forces_;
};

}  // namespace tissued::core
