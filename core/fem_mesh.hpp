// The nodes and elements of a finite element body: linear (P1) or quadratic (P2, straight-edged) tetrahedra on the same
// TetMesh.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/mesh.hpp"

namespace tissued::core {

enum class FemElement { p1, p2 };

inline constexpr int kMostElementNodes = 10;
// The edge that carries node 4 + k of a quadratic tetrahedron; VTK's order.
inline constexpr std::array<std::array<int, 2>, 6> kTetEdges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

// Entries beyond those of the element are zero.
using ShapeValues = std::array<double, kMostElementNodes>;
using ShapeSlopes = std::array<std::array<double, 4>, kMostElementNodes>;  // by barycentric coordinate

int nodes_per_element(FemElement element);
ShapeValues shape_values(FemElement element, const std::array<double, 4>& barycentric);
ShapeSlopes shape_slopes(FemElement element, const std::array<double, 4>& barycentric);
// The integral of each shape function, as a share of the element's volume.
ShapeValues shape_integrals(FemElement element);

struct FemMesh {
  FemElement element = FemElement::p1;
  int corner_count = 0;                                            // nodes of the TetMesh: they come first
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> rest;  // (n x 3) mm, tissue; then the middles of edges
  std::vector<std::array<int, 2>> edges;                           // of node corner_count + k, ascending; P2 only
  std::vector<int> elements;                                       // (tets x nodes per element)
  std::vector<double> volumes;                                     // (tets) mm3

  int node_count() const { return static_cast<int>(rest.rows()); }
  int element_nodes() const { return nodes_per_element(element); }
  int element_count() const { return static_cast<int>(volumes.size()); }
  std::span<const int> nodes_of_element(int e) const {
    return {elements.data() + static_cast<std::ptrdiff_t>(e) * element_nodes(),
            static_cast<std::size_t>(element_nodes())};
  }
  // The node in the middle of an edge of the mesh. P2 only.
  int middle_of(int corner, int other) const;
};

FemMesh make_fem_mesh(const TetMesh& mesh, FemElement element);

// The nodes that lie on the facets of a group, ascending, each once.
std::vector<int> nodes_of(const FemMesh& mesh, const SurfaceGroup& group);
// How a force that acts evenly on the facets of a group is shared out over its nodes (entries beside `nodes_of`).
std::vector<double> shares_of(const FemMesh& mesh, const SurfaceGroup& group);

// A material point by the shape functions: position = sum_a weights[a] x[nodes[a]]; zero weights beyond `count`.
struct FemPoint {
  std::array<int, kMostElementNodes> nodes{};
  std::array<double, kMostElementNodes> weights{};
  int count = 0;
};

// point: barycentric in a tetrahedron or on a facet of the TetMesh.
FemPoint fem_point(const FemMesh& mesh, const MaterialPoint& point);
// x: (3n) mm.
Vec3 position_of(const FemPoint& point, const Eigen::VectorXd& x);

}  // namespace tissued::core
