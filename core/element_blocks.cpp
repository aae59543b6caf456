#include "core/element_blocks.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tissued::core {

std::vector<ElementBlock> make_element_blocks(const TetMesh& mesh, const Material& material, double weight_scale) {
  const int elements = mesh.tet_count();
  std::vector<ElementBlock> blocks(static_cast<std::size_t>((elements + kLanes - 1) / kLanes));
  const double mu = material.shear_modulus(), kappa = material.bulk_modulus();
  for (int i = 0; i < static_cast<int>(blocks.size()) * kLanes; ++i) {
    ElementBlock& block = blocks[i / kLanes];
    const int lane = i % kLanes;
    const Tet& tet = mesh.tets[std::min(i, elements - 1)];
    Mat3 edges;  // columns: x_a - x_0
    for (int a = 0; a < 3; ++a) edges.col(a) = mesh.node(tet[a + 1]) - mesh.node(tet[0]);
    const Mat3 gradients = edges.inverse();  // row a: gradient of shape function a + 1
    const double volume = edges.determinant() / 6.0;
    for (int a = 0; a < 4; ++a) block.row[a][lane] = 4 * static_cast<std::int64_t>(tet[a]);
    for (int a = 0; a < 3; ++a)
      for (int axis = 0; axis < 3; ++axis) block.gradient[a][axis][lane] = gradients(a, axis);
    block.volume[lane] = i < elements ? volume : 0.0;
    block.shear_modulus[lane] = mu;
    block.bulk_modulus[lane] = kappa;
    block.stiffness[lane] = weight_scale * (kappa + 4.0 / 3.0 * mu);
    block.edge[lane] = std::cbrt(6.0 * volume);
  }
  return blocks;
}

void reset_element_states(std::vector<ElementState>& states) {
  for (ElementState& state : states) {
    state = ElementState{};
    for (int lane = 0; lane < kLanes; ++lane) {
      for (int i = 0; i < 3; ++i) {
        state.v[4 * i][lane] = 1.0;
        state.stretch[i][lane] = 1.0;
      }
    }
  }
}

}  // namespace tissued::core
