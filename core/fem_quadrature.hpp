// Quadrature on the tetrahedron.
#pragma once

#include <array>
#include <vector>

namespace tissued::core {

struct TetQuadrature {
  std::vector<std::array<double, 4>> points;  // barycentric
  std::vector<double> weights;                // sum to 1: shares of the element's volume

  int count() const { return static_cast<int>(weights.size()); }
};

// Exact for polynomials up to `degree`, 1 to 9: the symmetric rules of 1, 4, 5, 14 and 24 points (degrees 1, 2, 3, 5
// and 6), a collapsed product of Gauss rules beyond. Only that of degree 3 has a negative weight. Throws ModelError
// elsewhere.
TetQuadrature tet_quadrature(int degree);

}  // namespace tissued::core
