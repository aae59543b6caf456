#include "core/fem_inertia.hpp"

#include "core/fem_quadrature.hpp"

namespace tissued::core {

FemInertia::FemInertia(const FemMesh& mesh, double density, MassMatrix kind) : mesh_(&mesh), density_(density) {
  constexpr int kExact = 4;  // the product of two quadratic shape functions
  const TetQuadrature rule = tet_quadrature(kExact);
  for (int q = 0; q < rule.count(); ++q) {
    const ShapeValues n = shape_values(mesh.element, rule.points[q]);
    for (std::size_t a = 0; a < n.size(); ++a)
      for (std::size_t b = 0; b < n.size(); ++b) shares_[a][b] += rule.weights[q] * n[a] * n[b];
  }
  if (kind == MassMatrix::consistent) return;
  double diagonal = 0.0;
  for (std::size_t a = 0; a < shares_.size(); ++a) diagonal += shares_[a][a];
  for (std::size_t a = 0; a < shares_.size(); ++a)
    for (std::size_t b = 0; b < shares_.size(); ++b) shares_[a][b] = a == b ? shares_[a][a] / diagonal : 0.0;
}

void FemInertia::multiply(int element, double mass, const double* x, double* residual) const {
  const std::span<const int> nodes = nodes_of_entity(element);
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    for (int axis = 0; axis < 3; ++axis) {
      double sum = 0.0;
      for (std::size_t b = 0; b < nodes.size(); ++b) sum += shares_[a][b] * x[3 * nodes[b] + axis];
      residual[3 * a + axis] = mass * sum;
    }
  }
}

void FemInertia::evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const {
  const int n = nodes_per_entity();
  std::array<double, 3 * kMostElementNodes> residual;
  for (int e = begin; e < end; ++e) {
    const double mass = density_ * kKilogramPerDensityVolume * mesh_->volumes[e];
    multiply(e, mass, input.x, residual.data());
    if (output.residual != nullptr)
      std::copy_n(residual.begin(), 3 * n, output.residual + static_cast<std::ptrdiff_t>(e) * 3 * n);
    if (output.energy != nullptr) {
      output.energy[e] = 0.0;
      for (int a = 0; a < n; ++a)
        for (int axis = 0; axis < 3; ++axis)
          output.energy[e] += 0.5 * residual[3 * a + axis] * input.x[3 * nodes_of_entity(e)[a] + axis];
    }
    if (output.tangent == nullptr) continue;
    double* block = output.tangent + static_cast<std::ptrdiff_t>(e) * 9 * pair_count(n);
    for (int a = 0; a < n; ++a)
      for (int b = 0; b <= a; ++b, block += 9)
        for (int k = 0; k < 9; ++k) block[k] = k % 4 == 0 ? mass * shares_[a][b] : 0.0;
  }
}

std::span<const FemParameter> FemInertia::parameters() const {
  static const std::array<FemParameter, 1> kParameters{{{"density", "g/cm3", 0.0, 100.0}}};
  return kParameters;
}

void FemInertia::differentiate(int, int begin, int end, const TermInput& input, double* residual) const {
  for (int e = begin; e < end; ++e)
    multiply(e, kKilogramPerDensityVolume * mesh_->volumes[e], input.x,
             residual + static_cast<std::ptrdiff_t>(e) * 3 * nodes_per_entity());
}

}  // namespace tissued::core
