// What every effect must pass, and points of material for tests against formulas.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/effects/effect.hpp"
#include "core/fem_solver.hpp"
#include "tests/core/test_bodies.hpp"

namespace tissued::core::testing {

// A number that is not neutral.
struct Chosen {
  std::string name;  // as EffectParameter
  double value;
};

// neutral(scene), but for what is chosen.
std::vector<double> chosen_values(const Effect& effect, const Scene& scene, const std::vector<Chosen>& chosen);

// On a box of P1 and of P2, far from rest and with a past: the tangent is the derivative of the residual, and the
// residual that of the energy, also where time passes.
void check_derivatives(const Effect& effect, const std::vector<Chosen>& chosen);

// At neutral numbers a pushed body answers as one without the effect, to `tolerance` mm and 10 times as many N.
void check_neutral(const Effect& effect, double tolerance);

// The words name the effect's numbers, and the table of its parameters holds together.
void check_words(const Effect& effect, const std::vector<Chosen>& chosen);

PadInput pushed(const Pad& pad, const Vec3& way);

// From rest to these pads in one step without time; it must converge.
FemState solved(const FemModel& model, const std::vector<PadInput>& pads);

// A point of material under a deformation that is the same in all lanes: neo-Hookean and the effect's laws.
class MaterialPointTwin {
 public:
  MaterialPointTwin(const Effect& effect, const Scene& scene, const std::vector<Chosen>& chosen);
  // kPa, first Piola-Kirchhoff, after time_step s since the last accepted deformation.
  Mat3 stress(const Mat3& f, double time_step) const;
  void accept(const Mat3& f, double time_step);
  // The stretch across, free of stress, of a bar that is stretched along x by this much; and the stress along x.
  double across(double along, double time_step) const;
  double bar_stress(double along, double time_step) const;
  void accept_bar(double along, double time_step);

 private:
  std::vector<std::unique_ptr<FemLaw>> laws_;
  std::vector<std::vector<double>> history_;
};

}  // namespace tissued::core::testing
