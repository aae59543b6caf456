#include "core/strain_domains.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace tissued::core {

namespace {

// How much of the shear modulus the nodes carry, edges the rest. Edges alone are 2 to 3 % too stiff on the reference
// bodies, nodes alone a quarter too soft.
double shear_at_nodes(Element element) {
  constexpr double kSmoothed = 0.1;
  return element == Element::node ? 1.0 : element == Element::smoothed ? kSmoothed : 0.0;
}

struct LinearElement {
  std::array<Vec3, 4> gradients;  // 1/mm, of the shape functions
  double volume;                  // mm3
};

std::vector<LinearElement> linear_elements(const TetMesh& mesh) {
  std::vector<LinearElement> elements;
  elements.reserve(mesh.tets.size());
  for (const Tet& tet : mesh.tets) {
    Mat3 edges;  // columns: x_a - x_0
    for (int a = 0; a < 3; ++a) edges.col(a) = mesh.node(tet[a + 1]) - mesh.node(tet[0]);
    const Mat3 inverse = edges.inverse();  // row a: gradient of shape function a + 1
    LinearElement element;
    element.gradients[0] = -inverse.colwise().sum().transpose();
    for (int a = 0; a < 3; ++a) element.gradients[a + 1] = inverse.row(a).transpose();
    element.volume = edges.determinant() / 6.0;
    elements.push_back(element);
  }
  return elements;
}

// Average of the elements' gradients, each weighted with `share` of its volume.
StrainDomain average(const TetMesh& mesh, const std::vector<LinearElement>& elements, const std::vector<int>& members,
                     double share) {
  std::vector<std::pair<int, Vec3>> corners;
  StrainDomain domain;
  for (int e : members) {
    domain.volume += share * elements[e].volume;
    for (int a = 0; a < 4; ++a)
      corners.emplace_back(mesh.tets[e][a], share * elements[e].volume * elements[e].gradients[a]);
  }
  std::stable_sort(corners.begin(), corners.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [node, gradient] : corners) {
    if (domain.nodes.empty() || domain.nodes.back() != node) {
      domain.nodes.push_back(node);
      domain.gradients.push_back(Vec3::Zero());
    }
    domain.gradients.back() += gradient / domain.volume;
  }
  return domain;
}

using EdgeMembers = std::map<std::pair<int, int>, std::vector<int>>;

EdgeMembers elements_of_edges(const TetMesh& mesh) {
  EdgeMembers edges;
  for (int e = 0; e < mesh.tet_count(); ++e)
    for (int a = 1; a < 4; ++a)
      for (int b = 0; b < a; ++b) edges[std::minmax(mesh.tets[e][a], mesh.tets[e][b])].push_back(e);
  return edges;
}

std::vector<std::vector<int>> elements_of_nodes(const TetMesh& mesh) {
  std::vector<std::vector<int>> members(static_cast<std::size_t>(mesh.node_count()));
  for (int e = 0; e < mesh.tet_count(); ++e)
    for (int node : mesh.tets[e]) members[node].push_back(e);
  return members;
}

}  // namespace

std::vector<StrainDomain> strain_domains(const TetMesh& mesh, const Material& material, Element element) {
  // Nothing but its nodes' volumes keeps an edge from collapsing, and the shape's energy stiffens as it does: with its
  // stiffness at rest, 4/3 mu, the iteration cycles on pushes of 15 mm.
  constexpr double kEdgeStiffness = 4.0;  // of the edge's shear modulus
  const std::vector<LinearElement> elements = linear_elements(mesh);
  const double mu = material.shear_modulus(), kappa = material.bulk_modulus();
  std::vector<StrainDomain> domains;
  const auto add = [&](StrainDomain domain, std::vector<int> anchors, double shear_modulus, double bulk_modulus,
                       double stiffness) {
    domain.anchors = std::move(anchors);
    domain.shear_modulus = shear_modulus;
    domain.bulk_modulus = bulk_modulus;
    domain.stiffness = stiffness;
    domains.push_back(std::move(domain));
  };
  if (element == Element::p1) {
    for (int e = 0; e < mesh.tet_count(); ++e)
      add(average(mesh, elements, {e}, 1.0), {mesh.tets[e].begin(), mesh.tets[e].end()}, mu, kappa,
          kappa + 4.0 / 3.0 * mu);
    return domains;
  }
  const double at_nodes = shear_at_nodes(element) * mu, at_edges = mu - at_nodes;
  const double bulk_at_edges = element == Element::edge ? kappa : 0.0;
  if (element != Element::node)
    for (const auto& [edge, members] : elements_of_edges(mesh))
      add(average(mesh, elements, members, 1.0 / 6.0), {edge.first, edge.second}, at_edges, bulk_at_edges,
          bulk_at_edges + kEdgeStiffness * at_edges);
  if (element == Element::edge) return domains;
  const auto around = elements_of_nodes(mesh);
  for (int node = 0; node < mesh.node_count(); ++node)
    add(average(mesh, elements, around[node], 1.0 / 4.0), {node}, at_nodes, kappa, kappa + 4.0 / 3.0 * at_nodes);
  return domains;
}

}  // namespace tissued::core
