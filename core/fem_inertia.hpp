// The mass of the body as a quadratic form: energy 1/2 x.M x, residual M x, tangent M. What the time schemes multiply
// accelerations with; not part of the static energy.
#pragma once

#include "core/fem_mesh.hpp"
#include "core/fem_term.hpp"

namespace tissued::core {

enum class MassMatrix { consistent, lumped };  // lumped: the consistent diagonal, scaled to the element's mass

class FemInertia final : public FemTerm {
 public:
  FemInertia(const FemMesh& mesh, double density, MassMatrix kind);

  std::string_view name() const override { return "inertia"; }
  int entity_count() const override { return mesh_->element_count(); }
  int nodes_per_entity() const override { return mesh_->element_nodes(); }
  std::span<const int> nodes_of_entity(int entity) const override { return mesh_->nodes_of_element(entity); }
  void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const override;

  std::span<const FemParameter> parameters() const override;  // density
  double parameter(int) const override { return density_; }
  void set_parameter(int, double value) override { density_ = value; }
  bool has_derivative(int) const override { return true; }
  void differentiate(int index, int begin, int end, const TermInput& input, double* residual) const override;

 private:
  // M x of one element of mass `mass`, kg.
  void multiply(int element, double mass, const double* x, double* residual) const;

  const FemMesh* mesh_;
  double density_;
  std::array<std::array<double, kMostElementNodes>, kMostElementNodes> shares_{};  // of the element's mass
};

}  // namespace tissued::core
