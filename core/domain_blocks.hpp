// Strain domains, eight to a block, one per SIMD lane (array of structures of arrays), and the local step on them.
#pragma once

#include <vector>

#include "core/fem_law.hpp"
#include "core/strain_domains.hpp"

namespace tissued::core {

inline constexpr int kLanes = 8;

// Constant over a run. Lanes past the last domain repeat it with zero volume, so that no lane is special.
struct alignas(64) DomainBlock {
  double volume[kLanes];         // mm3
  double shear_modulus[kLanes];  // kPa
  double bulk_modulus[kLanes];   // kPa
  double stiffness[kLanes];      // kPa; k_i of the ADMM weight w_i^2 = k_i V_i
  double length[kLanes];         // mm; cube root of six times the volume, turns strain into a length
  std::int64_t first_corner;     // of the block's, in the array of corners
  std::int64_t corner_count;     // the most of its lanes; at least 2
};

// One node of each of a block's domains. A lane with fewer nodes repeats its first with no gradient.
struct alignas(64) DomainCorner {
  std::int64_t row[kLanes];    // offset of the node's row in a NodeField: 4 * node
  double gradient[3][kLanes];  // [axis] 1/mm
};

struct DomainBlocks {
  std::vector<DomainBlock> blocks;
  std::vector<DomainCorner> corners;
  std::vector<int> domain;  // of every lane of every block; the repeated ones -1

  int count() const { return static_cast<int>(blocks.size()); }
};

// Domains with equally many nodes share blocks; those of linear tetrahedra keep their order. k_i = weight_scale
// times the domain's stiffness.
DomainBlocks make_domain_blocks(const std::vector<StrainDomain>& domains, double weight_scale);

// Written by the local step, one per block. u and the warm starts persist from one iteration, and one frame, to the
// next.
struct alignas(64) DomainState {
  double u[9][kLanes];        // scaled dual, row-major 3 x 3
  double v[9][kLanes];        // right singular vectors of Dx + u, row-major, det = 1; warm start
  double stretch[3][kLanes];  // singular values of z; warm start
  double factor[kLanes];      // on the domain's moduli, 1 unless something was learnt about them
};

// Written by the local step, read by the assembly of the global step; one per corner.
struct alignas(64) CornerForce {
  double force[3][kLanes];  // [axis] mN; minus D^T W^2 (Dx - z + u)
};

struct LocalStepResult {
  double primal = 0.0;  // mm; largest |Dx - z|_F length
  int inverted = 0;     // domains with det(Dx) <= 0
  int unconverged = 0;  // local problems that used up their Newton iterations
};

// u = 0, z = I.
void reset_domain_states(std::vector<DomainState>& states);

// Local step (10) for blocks [first, last): z = argmin Psi(z) + k/2 |Dx - z + u|^2 by singular values and Newton, then
// u += Dx - z, then the corner forces of the global step. x: NodeField rows, mm. deformations: null, or where Dx of
// every block goes.
LocalStepResult local_step(const DomainBlocks& blocks, int first, int last, const double* x, DomainState* states,
                           CornerForce* forces, PointDeformation* deformations = nullptr);

}  // namespace tissued::core
