#include "core/effects/facet.hpp"

#include <Eigen/Geometry>

namespace tissued::core {

Facet make_facet(const FemMesh& mesh, const Triangle& triangle) {
  Facet facet;
  facet.count = mesh.element == FemElement::p1 ? 3 : 6;
  Vec3 corner[3];
  for (std::size_t k = 0; k < 3; ++k) {
    facet.nodes[k] = triangle[k];
    if (facet.count == 6) facet.nodes[3 + k] = mesh.middle_of(triangle[k], triangle[(k + 1) % 3]);
    corner[k] = mesh.rest.row(triangle[k]).transpose();
  }
  const Vec3 twice = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  facet.area = 0.5 * twice.norm();
  facet.normal = twice.normalized();
  // Across the opposite edge, 1 / height long.
  for (int k = 0; k < 3; ++k)
    facet.slope[k] = facet.normal.cross(corner[(k + 2) % 3] - corner[(k + 1) % 3]) / (2.0 * facet.area);
  return facet;
}

const std::array<FacetPoint, kFacetPoints>& facet_rule() {
  constexpr double kA = 0.445948490915965, kWeightA = 0.223381589678011;
  constexpr double kB = 0.091576213509771, kWeightB = 0.109951743655322;
  static const std::array<FacetPoint, kFacetPoints> kRule{{{{kA, kA, 1.0 - 2.0 * kA}, kWeightA},
                                                           {{kA, 1.0 - 2.0 * kA, kA}, kWeightA},
                                                           {{1.0 - 2.0 * kA, kA, kA}, kWeightA},
                                                           {{kB, kB, 1.0 - 2.0 * kB}, kWeightB},
                                                           {{kB, 1.0 - 2.0 * kB, kB}, kWeightB},
                                                           {{1.0 - 2.0 * kB, kB, kB}, kWeightB}}};
  return kRule;
}

std::array<double, kMostFacetNodes> facet_shapes(int count, const std::array<double, 3>& barycentric) {
  std::array<double, kMostFacetNodes> shapes{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double l = barycentric[k];
    shapes[k] = count == 3 ? l : l * (2.0 * l - 1.0);
    if (count == 6) shapes[3 + k] = 4.0 * l * barycentric[(k + 1) % 3];
  }
  return shapes;
}

std::array<Vec3, kMostFacetNodes> facet_slopes(const Facet& facet, const std::array<double, 3>& barycentric) {
  std::array<Vec3, kMostFacetNodes> slopes;
  slopes.fill(Vec3::Zero());
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    slopes[k] = facet.count == 3 ? facet.slope[k] : Vec3((4.0 * barycentric[k] - 1.0) * facet.slope[k]);
    if (facet.count == 6)
      slopes[3 + k] = 4.0 * (barycentric[next] * facet.slope[k] + barycentric[k] * facet.slope[next]);
  }
  return slopes;
}

Vec3 rest_on_facet(const FemMesh& mesh, const Facet& facet, const std::array<double, 3>& barycentric) {
  Vec3 rest = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k) rest += barycentric[k] * mesh.rest.row(facet.nodes[k]).transpose();
  return rest;
}

}  // namespace tissued::core
