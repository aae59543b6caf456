#include "core/mesh.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <map>

namespace tissued::core {

const SurfaceGroup* TetMesh::find_surface(const std::string& name) const {
  const auto it = std::find_if(surfaces.begin(), surfaces.end(), [&](const SurfaceGroup& g) { return g.name == name; });
  return it == surfaces.end() ? nullptr : &*it;
}

std::vector<int> nodes_of(const SurfaceGroup& group) {
  std::vector<int> nodes;
  nodes.reserve(3 * group.triangles.size());
  for (const Triangle& t : group.triangles) nodes.insert(nodes.end(), t.begin(), t.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

double signed_volume(const TetMesh& mesh, const Tet& tet) {
  const Vec3 origin = mesh.node(tet[0]);
  Mat3 edges;
  for (int a = 0; a < 3; ++a) edges.col(a) = mesh.node(tet[a + 1]) - origin;
  return edges.determinant() / 6.0;
}

Vec3 rest_position(const TetMesh& mesh, const MaterialPoint& point) {
  Vec3 p = Vec3::Zero();
  for (int a = 0; a < point.count; ++a) p += point.weights[a] * mesh.node(point.nodes[a]);
  return p;
}

namespace {

// Barycentric coordinates of the point of triangle (a, b, c) closest to p (Ericson, Real-Time Collision
// Detection 5.1.5).
std::array<double, 3> closest_in_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double v = d1 / (d1 - d3);
    return {1 - v, v, 0};
  }
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double w = d2 / (d2 - d6);
    return {1 - w, 0, w};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double denominator = 1.0 / (va + vb + vc);
  return {1 - (vb + vc) * denominator, vb * denominator, vc * denominator};
}

MaterialPoint on_facet(const TetMesh& mesh, const Triangle& facet, const Vec3& position) {
  const auto weights = closest_in_triangle(mesh.node(facet[0]), mesh.node(facet[1]), mesh.node(facet[2]), position);
  MaterialPoint point;
  point.count = 3;
  for (int a = 0; a < 3; ++a) {
    point.nodes[a] = facet[a];
    point.weights[a] = weights[a];
  }
  point.distance = (rest_position(mesh, point) - position).norm();
  return point;
}

// Outward facets of a tetrahedron of positive volume.
constexpr int kFacets[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

}  // namespace

MaterialPoint locate_on_surface(const TetMesh& mesh, const std::vector<Triangle>& facets, const Vec3& position) {
  MaterialPoint best;
  best.distance = std::numeric_limits<double>::infinity();
  for (const Triangle& facet : facets) {
    const MaterialPoint candidate = on_facet(mesh, facet, position);
    if (candidate.distance < best.distance) best = candidate;
  }
  return best;
}

std::array<double, 4> barycentric_in(const TetMesh& mesh, const Tet& tet, const Vec3& position) {
  Mat3 edges;
  for (int a = 0; a < 3; ++a) edges.col(a) = mesh.node(tet[a + 1]) - mesh.node(tet[0]);
  const Vec3 local = edges.inverse() * (position - mesh.node(tet[0]));
  return {1.0 - local.sum(), local[0], local[1], local[2]};
}

MaterialPoint locate_in_volume(const TetMesh& mesh, const Vec3& position) {
  constexpr double kInside = -1e-9;
  for (const Tet& tet : mesh.tets) {
    const std::array<double, 4> weights = barycentric_in(mesh, tet, position);
    if (*std::min_element(weights.begin(), weights.end()) < kInside) continue;
    MaterialPoint point;
    point.count = 4;
    point.nodes = tet;
    point.weights = weights;
    return point;
  }
  return locate_on_surface(mesh, boundary_of(mesh), position);
}

std::vector<Triangle> boundary_of(const TetMesh& mesh) {
  std::map<Triangle, std::pair<Triangle, int>> seen;  // sorted facet -> oriented facet and how often
  for (const Tet& tet : mesh.tets) {
    for (const auto& f : kFacets) {
      const Triangle facet{tet[f[0]], tet[f[1]], tet[f[2]]};
      Triangle key = facet;
      std::sort(key.begin(), key.end());
      auto [it, fresh] = seen.try_emplace(key, facet, 0);
      ++it->second.second;
    }
  }
  std::vector<Triangle> boundary;
  for (const auto& [key, facet] : seen)
    if (facet.second == 1) boundary.push_back(facet.first);
  return boundary;
}

}  // namespace tissued::core
