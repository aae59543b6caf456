// The weight of the body, a dead force: energy -rho g0 gravity . integral of x.
#pragma once

#include "core/fem_mesh.hpp"
#include "core/fem_term.hpp"

namespace tissued::core {

class FemGravity final : public FemTerm {
 public:
  // gravity: multiples of g0; density: g/cm3.
  FemGravity(const FemMesh& mesh, const Vec3& gravity, double density);

  std::string_view name() const override { return "gravity"; }
  int entity_count() const override { return mesh_->element_count(); }
  int nodes_per_entity() const override { return mesh_->element_nodes(); }
  std::span<const int> nodes_of_entity(int entity) const override { return mesh_->nodes_of_element(entity); }
  bool has_tangent() const override { return false; }
  void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const override;

  std::span<const FemParameter> parameters() const override;  // gravity_x, gravity_y, gravity_z, density
  double parameter(int index) const override;
  void set_parameter(int index, double value) override;
  bool has_derivative(int) const override { return true; }
  void differentiate(int index, int begin, int end, const TermInput& input, double* residual) const override;

 private:
  // Residual of one element under the force density `force`, mN/mm3.
  void weigh(int element, const Vec3& force, double* residual) const;

  const FemMesh* mesh_;
  ShapeValues shares_;
  Vec3 gravity_;
  double density_;
};

}  // namespace tissued::core
