// Facets of a finite element body, flat triangles with three nodes or six, and how to integrate over them.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/fem_mesh.hpp"

namespace tissued::core {

inline constexpr int kMostFacetNodes = 6;
inline constexpr int kFacetPoints = 6;

// Corners, then the middles of edges (0, 1), (1, 2), (2, 0).
struct Facet {
  std::array<int, kMostFacetNodes> nodes{};
  int count = 0;      // 3 or 6
  double area = 0.0;  // mm2, at rest
  Vec3 normal;        // unit, as the triangle is oriented
  Vec3 slope[3];      // 1/mm: gradients of the barycentric coordinates in the plane
};

Facet make_facet(const FemMesh& mesh, const Triangle& triangle);

// A point of the rule that is exact for polynomials of degree 4; weights are shares of the area.
struct FacetPoint {
  std::array<double, 3> barycentric;
  double weight;
};
const std::array<FacetPoint, kFacetPoints>& facet_rule();

// Of the shape functions; entries beyond `count` are zero.
std::array<double, kMostFacetNodes> facet_shapes(int count, const std::array<double, 3>& barycentric);
// (1/mm), in the plane of the facet.
std::array<Vec3, kMostFacetNodes> facet_slopes(const Facet& facet, const std::array<double, 3>& barycentric);
// mm, tissue, at rest.
Vec3 rest_on_facet(const FemMesh& mesh, const Facet& facet, const std::array<double, 3>& barycentric);

}  // namespace tissued::core
