// `rigid`: a body that does not deform, which is what guidance systems in clinics assume. The others are measured
// against it.
#pragma once

#include "core/simulator.hpp"

namespace tissued::core {

class RigidSimulator final : public Simulator {
 public:
  // Throws ModelError.
  RigidSimulator(const Scene& scene, const SimulatorOptions& options);

  const Scene& scene() const override { return scene_; }
  void reset() override;
  // With Follow::markers, the rigid motion that takes the seen markers from rest to where they are, in the sense of
  // least squares. A marker whose square is not finite counts as not seen. Fewer than three, or on a line, they leave
  // the body where it was.
  StepReport step(const Observation& observation) noexcept override;
  void set_time_step(double time_step) override { time_step_ = time_step; }
  double time_step() const override { return time_step_; }
  const NodeField& positions() const override { return positions_; }
  TargetEstimate target(int index) const noexcept override;
  Vec3 marker(int index) const noexcept override;
  // Zero: a rigid body says nothing about forces.
  Vec3 pad_force(int) const noexcept override { return Vec3::Zero(); }
  Vec3 probe_force(int) const noexcept override { return Vec3::Zero(); }
  std::uint64_t state_hash() const noexcept override;

 private:
  void follow(const Observation& observation, StepReport& report);
  void publish();

  Scene scene_;
  RigidOptions options_;
  double time_step_;
  RigidTransform motion_;        // from rest to now
  std::vector<Vec3> from_, to_;  // (markers used) mm, at rest and now
  NodeField positions_;
};

}  // namespace tissued::core
