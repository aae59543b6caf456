// Linear tetrahedra, eight to a block, one element per SIMD lane (array of structures of arrays).
#pragma once

#include <vector>

#include "core/mesh.hpp"
#include "core/scene.hpp"

namespace tissued::core {

inline constexpr int kLanes = 8;

// Constant over a run. Lanes past the last element repeat it with zero volume, so that no lane is special.
struct alignas(64) ElementBlock {
  std::int64_t row[4][kLanes];    // offset of the node's row in a NodeField: 4 * node
  double gradient[3][3][kLanes];  // [a - 1][axis] of shape function a = 1..3, 1/mm; a = 0 is minus their sum
  double volume[kLanes];          // mm3
  double shear_modulus[kLanes];   // kPa
  double bulk_modulus[kLanes];    // kPa
  double stiffness[kLanes];       // kPa; k_i of the ADMM weight w_i^2 = k_i V_i
  double edge[kLanes];            // mm; cube root of six times the volume, turns strain into a length
};

// Written by the local step. u and the warm starts persist from one iteration, and one frame, to the next.
struct alignas(64) ElementState {
  double u[9][kLanes];        // scaled dual, row-major 3 x 3
  double v[9][kLanes];        // right singular vectors of Dx + u, row-major, det = 1; warm start
  double stretch[3][kLanes];  // singular values of z; warm start
};

// Written by the local step, read by the assembly of the global step.
struct alignas(64) ElementForce {
  double force[4][3][kLanes];  // mN; minus D^T W^2 (Dx - z + u) of corner a, axis
};

struct LocalStepResult {
  double primal = 0.0;  // mm; largest |Dx - z|_F edge
  int inverted = 0;     // elements with det(Dx) <= 0
  int unconverged = 0;  // local problems that used up their Newton iterations
};

std::vector<ElementBlock> make_element_blocks(const TetMesh& mesh, const Material& material, double weight_scale);

// u = 0, z = I.
void reset_element_states(std::vector<ElementState>& states);

// Local step (10) for blocks [first, last): z = argmin Psi(z) + k/2 |Dx - z + u|^2 by singular values and Newton, then
// u += Dx - z, then the corner forces of the global step. x: NodeField rows, mm.
LocalStepResult local_step(const ElementBlock* blocks, int first, int last, const double* x, ElementState* states,
                           ElementForce* forces);

}  // namespace tissued::core
