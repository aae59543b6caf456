// Two things inside a body that the library has no effect for.
#pragma once

#include "core/effects/effect.hpp"

namespace tissued::core::testing {

// Fluid that fills a ball and is pumped in: its pressure grows evenly from rest on, whatever the pads do.
class FluidCavity final : public Effect {
 public:
  // mm; kPa/s.
  FluidCavity(const Vec3& center, double radius, double pressure_rate)
      : center_(center), radius_(radius), rate_(pressure_rate) {}

  std::string_view kind() const override { return "fluid-cavity"; }
  std::string_view title() const override { return "A cavity fills"; }
  std::string sentence(std::span<const double>) const override { return "A cavity fills."; }
  std::span<const EffectParameter> parameters() const override { return {}; }
  std::vector<int> amplitudes() const override { return {}; }
  bool has_history() const override { return true; }
  void add_to(const Scene& scene, const FemMesh& mesh, FemPhysics& physics) const override;

 private:
  Vec3 center_;
  double radius_, rate_;
};

// A dozen strings from the nodes around one end to those around the other, shorter by `tautness` than their distance at
// rest; they pull, and do not push.
class InnerCable final : public Effect {
 public:
  // mm; N/mm; mm.
  InnerCable(const Vec3& from, const Vec3& to, double stiffness, double tautness)
      : from_(from), to_(to), stiffness_(stiffness), tautness_(tautness) {}

  std::string_view kind() const override { return "inner-cable"; }
  std::string_view title() const override { return "A cable runs inside"; }
  std::string sentence(std::span<const double>) const override { return "A cable runs inside."; }
  std::span<const EffectParameter> parameters() const override { return {}; }
  std::vector<int> amplitudes() const override { return {}; }
  void add_to(const Scene& scene, const FemMesh& mesh, FemPhysics& physics) const override;

 private:
  Vec3 from_, to_;
  double stiffness_, tautness_;
};

}  // namespace tissued::core::testing
