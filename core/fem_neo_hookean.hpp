// Equation (11) with J = det F, and its first and second derivative in closed form.
#pragma once

#include <array>

#include "core/fem_law.hpp"
#include "core/scene.hpp"

namespace tissued::core {

class FemNeoHookean final : public FemLaw {
 public:
  explicit FemNeoHookean(const Material& material) : material_(material) {}

  std::string_view name() const override { return "neo-hookean"; }
  void add(const PointBatch& batch, const PointDeformation& deformation, bool tangent,
           PointResponse& response) const override;

  std::span<const FemParameter> parameters() const override;  // youngs_modulus, poissons_ratio
  double parameter(int index) const override;
  void set_parameter(int index, double value) override;
  bool has_derivative(int) const override { return true; }
  void differentiate(int index, const PointBatch& batch, const PointDeformation& deformation,
                     double (*stress)[kPointLanes]) const override;

 private:
  Material material_;
};

}  // namespace tissued::core
