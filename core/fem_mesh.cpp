#include "core/fem_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace tissued::core {

int nodes_per_element(FemElement element) { return element == FemElement::p1 ? 4 : 10; }

ShapeValues shape_values(FemElement element, const std::array<double, 4>& barycentric) {
  ShapeValues values{};
  for (std::size_t a = 0; a < 4; ++a) {
    const double l = barycentric[a];
    values[a] = element == FemElement::p1 ? l : l * (2.0 * l - 1.0);
  }
  if (element == FemElement::p1) return values;
  for (std::size_t k = 0; k < kTetEdges.size(); ++k)
    values[4 + k] = 4.0 * barycentric[kTetEdges[k][0]] * barycentric[kTetEdges[k][1]];
  return values;
}

ShapeSlopes shape_slopes(FemElement element, const std::array<double, 4>& barycentric) {
  ShapeSlopes slopes{};
  for (std::size_t a = 0; a < 4; ++a) slopes[a][a] = element == FemElement::p1 ? 1.0 : 4.0 * barycentric[a] - 1.0;
  if (element == FemElement::p1) return slopes;
  for (std::size_t k = 0; k < kTetEdges.size(); ++k) {
    const auto [i, j] = kTetEdges[k];
    slopes[4 + k][i] = 4.0 * barycentric[j];
    slopes[4 + k][j] = 4.0 * barycentric[i];
  }
  return slopes;
}

ShapeValues shape_integrals(FemElement element) {
  ShapeValues integrals{};
  const bool linear = element == FemElement::p1;
  std::fill_n(integrals.begin(), 4, linear ? 0.25 : -0.05);
  if (!linear) std::fill_n(integrals.begin() + 4, 6, 0.2);
  return integrals;
}

namespace {

std::array<int, 2> edge_key(int one, int other) { return {std::min(one, other), std::max(one, other)}; }

std::vector<std::array<int, 2>> edges_of(const TetMesh& mesh) {
  std::vector<std::array<int, 2>> edges;
  edges.reserve(6 * mesh.tets.size());
  for (const Tet& tet : mesh.tets)
    for (const auto& edge : kTetEdges) edges.push_back(edge_key(tet[edge[0]], tet[edge[1]]));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

double facet_area(const FemMesh& mesh, const Triangle& facet) {
  const Vec3 a = mesh.rest.row(facet[0]), b = mesh.rest.row(facet[1]), c = mesh.rest.row(facet[2]);
  return 0.5 * (b - a).cross(c - a).norm();
}

}  // namespace

int FemMesh::middle_of(int corner, int other) const {
  const auto it = std::lower_bound(edges.begin(), edges.end(), edge_key(corner, other));
  return corner_count + static_cast<int>(it - edges.begin());
}

FemMesh make_fem_mesh(const TetMesh& mesh, FemElement element) {
  FemMesh out;
  out.element = element;
  out.corner_count = mesh.node_count();
  if (element == FemElement::p2) out.edges = edges_of(mesh);
  out.rest.resize(out.corner_count + static_cast<Eigen::Index>(out.edges.size()), 3);
  out.rest.topRows(out.corner_count) = mesh.rest;
  for (std::size_t k = 0; k < out.edges.size(); ++k)
    out.rest.row(out.corner_count + static_cast<Eigen::Index>(k)) =
        0.5 * (mesh.rest.row(out.edges[k][0]) + mesh.rest.row(out.edges[k][1]));
  for (const Tet& tet : mesh.tets) {
    out.elements.insert(out.elements.end(), tet.begin(), tet.end());
    if (element == FemElement::p2)
      for (const auto& edge : kTetEdges) out.elements.push_back(out.middle_of(tet[edge[0]], tet[edge[1]]));
    out.volumes.push_back(signed_volume(mesh, tet));
  }
  return out;
}

std::vector<int> nodes_of(const FemMesh& mesh, const SurfaceGroup& group) {
  std::vector<int> nodes = nodes_of(group);
  if (mesh.element == FemElement::p2) {
    for (const Triangle& t : group.triangles)
      for (std::size_t k = 0; k < 3; ++k) nodes.push_back(mesh.middle_of(t[k], t[(k + 1) % 3]));
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  }
  return nodes;
}

std::vector<double> shares_of(const FemMesh& mesh, const SurfaceGroup& group) {
  const std::vector<int> nodes = nodes_of(mesh, group);
  std::vector<double> shares(nodes.size(), 0.0);
  double total = 0.0;
  for (const Triangle& t : group.triangles) {
    const double area = facet_area(mesh, t);
    total += area;
    for (std::size_t k = 0; k < 3; ++k) {
      // The integral of a quadratic facet's corner functions is zero, of its edge functions a third of the area.
      const int node = mesh.element == FemElement::p1 ? t[k] : mesh.middle_of(t[k], t[(k + 1) % 3]);
      shares[std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin()] += area / 3.0;
    }
  }
  for (double& share : shares) share /= total;
  return shares;
}

FemPoint fem_point(const FemMesh& mesh, const MaterialPoint& point) {
  FemPoint out;
  std::array<double, 4> foot = point.weights;
  for (std::size_t k = 0; k < 4; ++k) foot[k] -= point.stalk[k];
  ShapeValues values = shape_values(mesh.element, foot);
  // Beyond the body in a straight line: along the element's slope at the foot.
  const ShapeSlopes slopes = shape_slopes(mesh.element, foot);
  for (std::size_t a = 0; a < values.size(); ++a)
    for (std::size_t k = 0; k < 4; ++k) values[a] += slopes[a][k] * point.stalk[k];
  const auto add = [&](int node, double weight) {
    out.nodes[out.count] = node;
    out.weights[out.count++] = weight;
  };
  for (int a = 0; a < point.count; ++a) add(point.nodes[a], values[a]);
  if (mesh.element == FemElement::p1) return out;
  for (std::size_t k = 0; k < kTetEdges.size(); ++k) {
    const auto [i, j] = kTetEdges[k];
    if (i < point.count && j < point.count) add(mesh.middle_of(point.nodes[i], point.nodes[j]), values[4 + k]);
  }
  return out;
}

Vec3 position_of(const FemPoint& point, const Eigen::VectorXd& x) {
  Vec3 position = Vec3::Zero();
  for (int a = 0; a < point.count; ++a) position += point.weights[a] * x.segment<3>(3 * point.nodes[a]);
  return position;
}

}  // namespace tissued::core
