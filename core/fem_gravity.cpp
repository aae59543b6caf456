#include "core/fem_gravity.hpp"

#include <algorithm>

namespace tissued::core {

namespace {

constexpr double kForcePerDensity = kKilogramPerDensityVolume * kStandardGravity;  // mN/mm3 for 1 g/cm3 and 1 g0
constexpr int kDensity = 3;

}  // namespace

FemGravity::FemGravity(const FemMesh& mesh, const Vec3& gravity, double density)
    : mesh_(&mesh), shares_(shape_integrals(mesh.element)), gravity_(gravity), density_(density) {}

void FemGravity::weigh(int element, const Vec3& force, double* residual) const {
  for (int a = 0; a < nodes_per_entity(); ++a)
    for (int axis = 0; axis < 3; ++axis) residual[3 * a + axis] = -mesh_->volumes[element] * shares_[a] * force[axis];
}

void FemGravity::evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const {
  const int rows = 3 * nodes_per_entity();
  std::array<double, 3 * kMostElementNodes> residual{};
  const Vec3 force = density_ * kForcePerDensity * gravity_;
  if (force.isZero()) {
    if (output.residual != nullptr)
      std::fill_n(output.residual + static_cast<std::ptrdiff_t>(begin) * rows,
                  static_cast<std::ptrdiff_t>(end - begin) * rows, 0.0);
    if (output.energy != nullptr) std::fill(output.energy + begin, output.energy + end, 0.0);
    return;
  }
  for (int e = begin; e < end; ++e) {
    weigh(e, force, residual.data());
    if (output.residual != nullptr)
      std::copy_n(residual.begin(), rows, output.residual + static_cast<std::ptrdiff_t>(e) * rows);
    if (output.energy == nullptr) continue;
    output.energy[e] = 0.0;
    for (int a = 0; a < nodes_per_entity(); ++a)
      for (int axis = 0; axis < 3; ++axis)
        output.energy[e] += residual[3 * a + axis] * input.x[3 * nodes_of_entity(e)[a] + axis];
  }
}

std::span<const FemParameter> FemGravity::parameters() const {
  static const std::array<FemParameter, 4> kParameters{
      {{"gravity_x", "g0"}, {"gravity_y", "g0"}, {"gravity_z", "g0"}, {"density", "g/cm3", 0.0, 100.0}}};
  return kParameters;
}

double FemGravity::parameter(int index) const { return index == kDensity ? density_ : gravity_[index]; }

void FemGravity::set_parameter(int index, double value) { (index == kDensity ? density_ : gravity_[index]) = value; }

void FemGravity::differentiate(int index, int begin, int end, const TermInput&, double* residual) const {
  const Vec3 force =
      index == kDensity ? Vec3(kForcePerDensity * gravity_) : Vec3(density_ * kForcePerDensity * Vec3::Unit(index));
  for (int e = begin; e < end; ++e) weigh(e, force, residual + static_cast<std::ptrdiff_t>(e) * 3 * nodes_per_entity());
}

}  // namespace tissued::core
