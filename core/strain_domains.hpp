// Where the deformation gradient is averaged and which energy is asked of it there: the rows of D in equation (4).
//
// Linear tetrahedra (`p1`) lock: one gradient per element asks for too many constraints of too few nodes. `smoothed`
// averages the gradients of the elements around every edge for the shape and around every node for the volume (ES-FEM
// and NS-FEM, selectively): still linear in x, so ADMM, its constant factor and its filter stand as they are.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh.hpp"
#include "core/scene.hpp"

namespace tissued::core {

// Beside the two that are offered, what was tried on the way (scripts/elements): everything averaged over edges or over
// nodes, and the shape over edges alone where `smoothed` leaves the nodes a tenth of it.
enum class Element : std::uint8_t { p1, smoothed, edge, node, edge_node };

struct StrainDomain {
  std::vector<int> nodes;       // each once, ascending
  std::vector<Vec3> gradients;  // 1/mm, one per node, summing to nothing: F = sum_a x_a gradients[a]^T
  std::vector<int> anchors;     // the nodes it stands for: an element's four, an edge's two, or one
  double volume = 0.0;          // mm3
  double shear_modulus = 0.0;   // kPa, of this domain's share of energy (11)
  double bulk_modulus = 0.0;    // kPa, likewise; 0 where other domains carry it
  double stiffness = 0.0;       // kPa, near the energy's stiffest direction: what the ADMM weight is in proportion to
};

std::vector<StrainDomain> strain_domains(const TetMesh& mesh, const Material& material, Element element);

}  // namespace tissued::core
