// A physical effect that a simulation may have left out: words for a person, numbers with units and bounds, and what it
// adds to a finite element body. One file pair an effect, one line in effects.cpp; the kinds and the names of their
// parameters are those of the contract of diagnose.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/effects/effect_setting.hpp"
#include "core/fem_model.hpp"

namespace tissued::core {

struct EffectParameter {
  std::string name;  // components of a vector as center.x, center.y, center.z
  std::string unit;
  double lowest = 0.0, highest = 0.0;
  double neutral = 0.0;      // where the effect is absent; of a place, time or axis any sane start
  double typical = 1.0;      // how much it may well differ: prior sd, scale of differences; of the logarithm where that
  bool logarithmic = false;  // it is fitted in its logarithm
  bool fixed = false;        // is not fitted: a switch, or what the effect's simplest form does not need
};

// A number as a report gives it.
struct EffectNumber {
  std::string name, unit;
  double value = 0.0;
};

// Stateless; may be used from several threads.
class Effect {
 public:
  virtual ~Effect() = default;

  virtual std::string_view kind() const = 0;
  // In plain words, e.g. "The tissue relaxes while it is held".
  virtual std::string_view title() const = 0;
  // One plain sentence with the numbers; values: beside parameters().
  virtual std::string sentence(std::span<const double> values) const = 0;
  virtual std::span<const EffectParameter> parameters() const = 0;
  // Beside parameters(): EffectParameter::neutral, and what the scene knows better (its gravity, its middle).
  virtual std::vector<double> neutral(const Scene& scene) const;
  // Where fits may begin, the effect there to be seen: places over the body, axes, times. Unless said otherwise: the
  // first number at what is typical.
  virtual std::vector<std::vector<double>> starts(const Scene& scene) const;
  // Which numbers are at their neutral values exactly where the effect is absent, wherever the others are, and let
  // answers change smoothly there: one, or the components of a vector. Empty: none.
  virtual std::vector<int> amplitudes() const { return {0}; }
  // The first of them; -1: none.
  int amplitude() const { return amplitudes().empty() ? -1 : amplitudes().front(); }
  // Under the names of the contract where fitting uses others (r for 1/r, axis and k for a slope); else as they are.
  virtual std::vector<EffectNumber> reported(std::span<const double> values) const;

  // Adds laws, terms, fields, masses, or releases nodes, at neutral(scene). FemModel::set_parameter then knows every
  // parameter as kind.name, e.g. viscoelasticity.g1. Effects may be added together, in any order.
  virtual void add_to(const Scene& scene, const FemMesh& mesh, FemPhysics& physics) const = 0;
  // Sets those numbers of the scene itself that the effect is about, so that every simulator knows them.
  virtual void adjust(Scene&, std::span<const double>) const {}
  // True where answers depend on the path that led to them; solves then need their time step.
  virtual bool has_history() const { return false; }
  // True where only inertia shows it: solve with FemDynamics.
  virtual bool is_dynamic() const { return false; }
};

// All that are registered, in the order of the contract.
std::span<const Effect* const> effects();
// nullptr where there is none of that kind.
const Effect* find_effect(std::string_view kind);

// For FemOptions::effects.
FemEffect fem_effect(const Effect& effect);
// The scene with what effects change of its own numbers.
Scene adjusted(const Scene& scene, std::span<const EffectSetting> settings);
// What FemModel::set_parameter calls the parameter: kind.name.
std::string model_parameter(const Effect& effect, const EffectParameter& parameter);
// Sets all of the effect's numbers. Throws ModelError where one is out of its bounds.
void set_effect(FemModel& model, const Effect& effect, std::span<const double> values);

}  // namespace tissued::core
