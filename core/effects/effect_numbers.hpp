// The numbers of an effect inside a body, by the names that FemModel::set_parameter knows.
#pragma once

#include <utility>
#include <vector>

#include "core/effects/effect.hpp"

namespace tissued::core {

// A number of the body that an effect follows, under the body's own name.
struct BodyNumber {
  FemParameter parameter;
  double value;
};

std::vector<BodyNumber> moduli_of(const Scene& scene);   // youngs_modulus, poissons_ratio
std::vector<BodyNumber> gravity_of(const Scene& scene);  // gravity_x, gravity_y, gravity_z

// A FemLaw, FemTerm or FemField with the numbers of an effect, then those of the body that it follows.
template <typename Base>
class WithNumbers : public Base {
 public:
  WithNumbers(const Effect& effect, const Scene& scene, const std::vector<BodyNumber>& followed = {})
      : values_(effect.neutral(scene)) {
    for (const EffectParameter& p : effect.parameters())
      parameters_.push_back({model_parameter(effect, p), p.unit, p.lowest, p.highest});
    for (const BodyNumber& number : followed) {
      parameters_.push_back(number.parameter);
      values_.push_back(number.value);
    }
  }
  std::span<const FemParameter> parameters() const override { return parameters_; }
  double parameter(int index) const override { return values_[index]; }
  void set_parameter(int index, double value) override {
    values_[index] = value;
    changed();
  }

 protected:
  // Called when a number was set.
  virtual void changed() {}
  double number(int index) const { return values_[index]; }
  Vec3 vector(int index) const { return {values_[index], values_[index + 1], values_[index + 2]}; }
  double shear_modulus(int index) const { return values_[index] / (2.0 * (1.0 + values_[index + 1])); }
  double bulk_modulus(int index) const { return values_[index] / (3.0 * (1.0 - 2.0 * values_[index + 1])); }

 private:
  std::vector<FemParameter> parameters_;
  std::vector<double> values_;
};

}  // namespace tissued::core
