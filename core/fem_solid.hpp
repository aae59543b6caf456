// The volume: laws summed at the quadrature points of the elements and integrated, eight elements at a time.
#pragma once

#include <memory>
#include <vector>

#include "core/fem_law.hpp"
#include "core/fem_mesh.hpp"
#include "core/fem_quadrature.hpp"

namespace tissued::core {

// Constant over a run. Lanes past the last element repeat it with zero volume.
struct alignas(64) SolidBlock {
  std::int64_t row[kMostElementNodes][kPointLanes];  // offset of the node's x: 3 * node
  double gradient[4][3][kPointLanes];                // of the barycentric coordinates, 1/mm
  double volume[kPointLanes];                        // mm3
};

// One quadrature point of the reference element.
struct SolidPoint {
  int nodes;          // per element
  double weight;      // share of the element's volume
  ShapeSlopes slope;  // of the shape functions by the barycentric coordinates
};

class FemSolid final : public FemTerm {
 public:
  FemSolid(const FemMesh& mesh, const TetQuadrature& quadrature, std::vector<std::unique_ptr<FemLaw>> laws,
           std::vector<std::unique_ptr<FemField>> fields = {});

  std::string_view name() const override { return "solid"; }
  int entity_count() const override { return mesh_->element_count(); }
  int nodes_per_entity() const override { return mesh_->element_nodes(); }
  std::span<const int> nodes_of_entity(int entity) const override { return mesh_->nodes_of_element(entity); }
  int batch() const override { return kPointLanes; }
  void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const override;

  // The laws' parameters, one law after the other; then the fields'.
  std::span<const FemParameter> parameters() const override { return parameters_; }
  double parameter(int index) const override;
  void set_parameter(int index, double value) override;
  bool has_derivative(int index) const override;
  void differentiate(int index, int begin, int end, const TermInput& input, double* residual) const override;

  // Overwrites `residual` with its derivative by the logarithm of the stiffness, along `field` (elements x points).
  void differentiate_stiffness(const std::vector<double>& field, int begin, int end, const TermInput& input,
                               double* residual) const;

  std::size_t history_size() const override;
  void accept(const TermInput& input, double* history) const override;

  int points_per_element() const { return static_cast<int>(points_.size()); }
  // (elements x points per element): what the moduli are multiplied with, beside the fields; empty: 1 everywhere.
  const std::vector<double>& stiffness() const { return stiffness_; }
  void set_stiffness(std::vector<double> factors);
  // mm, tissue, at rest.
  Vec3 rest_of_point(int element, int point) const;

 private:
  struct Owner {
    FemAdjustable* owner;
    int law, index;  // law -1: a field
  };
  void multiply_fields();
  Vec3 rest_at(int element, const std::array<double, 4>& barycentric) const;
  PointBatch batch_of(std::size_t law, int block, int point, const TermInput& input) const;
  std::size_t history_offset(std::size_t law, int block, int point) const;
  // Overwrites response, scaled by volume, weight and stiffness.
  void respond(int block, int point, const PointDeformation& deformation, const TermInput& input, bool tangent,
               PointResponse& response) const;
  double scale(int block, int point, int lane) const;
  // Integrates what stress(block, point, deformation, stress[9][lanes]) gives, already scaled.
  template <typename Stress>
  void integrate(int begin, int end, const double* x, const Stress& stress, double* out) const;

  const FemMesh* mesh_;
  TetQuadrature quadrature_;
  std::vector<std::unique_ptr<FemLaw>> laws_;
  std::vector<std::unique_ptr<FemField>> fields_;
  std::vector<FemParameter> parameters_;
  std::vector<Owner> owners_;
  std::vector<SolidBlock> blocks_;
  std::vector<SolidPoint> points_;
  std::vector<double> stiffness_;
  std::vector<double> factors_;  // stiffness_ times the fields
};

// F at a point of eight elements; corners as gathered, (nodes x 3 x lanes) mm.
void solid_deformation(const SolidBlock& block, const SolidPoint& point, const double* corners,
                       PointDeformation& deformation);
// Adds the point's share to the nodes' residual, (nodes x 3 x lanes) mN.
void solid_add_residual(const SolidBlock& block, const SolidPoint& point, const double (*stress)[kPointLanes],
                        double* residual);
// Adds the point's share to the blocks (pairs x 9 x lanes) mN/mm, pairs in the order of pair_index.
void solid_add_tangent(const SolidBlock& block, const SolidPoint& point, const double (*tangent)[kPointLanes],
                       double* blocks);

}  // namespace tissued::core
