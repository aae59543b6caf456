#include "core/diagnosis/discretisation.hpp"

#include <utility>

#include "core/refined_mesh.hpp"

namespace tissued::core {

namespace {

// Where a node of the fine mesh lies in the coarse tetrahedron that it is a part of.
std::array<double, 4> barycentric_in(const Tet& tet, const std::array<int, 2>& ends) {
  std::array<double, 4> out{};
  for (int c = 0; c < 4; ++c)
    for (int end : ends) out[c] += tet[c] == end ? 0.5 : 0.0;
  return out;
}

// (3n) mm, every node of the fine body displaced as the coarse body is there.
Eigen::VectorXd interpolated(const TetMesh& mesh, const Eigen::VectorXd& coarse, const RefinedMesh& finer,
                             const FemMesh& fine_mesh) {
  const FemMesh coarse_mesh = make_fem_mesh(mesh, FemElement::p2);
  Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(fine_mesh.rest.data(), fine_mesh.rest.size());
  std::vector<std::uint8_t> is_done(static_cast<std::size_t>(fine_mesh.node_count()), 0);
  for (int e = 0; e < fine_mesh.element_count(); ++e) {
    const std::span<const int> nodes = fine_mesh.nodes_of_element(e),
                               coarse_nodes = coarse_mesh.nodes_of_element(e / 8);
    for (int a = 0; a < kMostElementNodes; ++a) {
      if (std::exchange(is_done[nodes[a]], 1)) continue;
      // A corner, or the middle of two.
      const int first = a < 4 ? a : kTetEdges[a - 4][0], second = a < 4 ? a : kTetEdges[a - 4][1];
      const Tet& tet = mesh.tets[e / 8];
      std::array<double, 4> place = barycentric_in(tet, finer.ends[nodes[first]]);
      const std::array<double, 4> other = barycentric_in(tet, finer.ends[nodes[second]]);
      for (int c = 0; c < 4; ++c) place[c] = 0.5 * (place[c] + other[c]);
      const ShapeValues shape = shape_values(FemElement::p2, place);
      for (std::size_t b = 0; b < coarse_nodes.size(); ++b)
        x.segment<3>(3 * nodes[a]) +=
            shape[b] * (coarse.segment<3>(3 * coarse_nodes[b]) - coarse_mesh.rest.row(coarse_nodes[b]).transpose());
    }
  }
  return x;
}

}  // namespace

FinerAnswer finer_answer(const Scene& scene, std::span<const PadInput> pads, const Eigen::VectorXd& coarse) {
  const RefinedMesh finer = refined(scene.mesh);
  Scene fine = scene;
  fine.mesh = finer.mesh;
  PathSolver solver(fine, {});
  FemState state = rest_state(solver.model());
  state.x = interpolated(scene.mesh, coarse, finer, solver.model().mesh());
  const FemControl control{5e-3, 20, 6.0, 0.05};
  FinerAnswer answer;
  answer.solved = solve_static(solver.equilibrium(), state, {pads, nullptr}, control).converged;
  if (answer.solved) answer.values = solver.observe(state, pads);
  return answer;
}

}  // namespace tissued::core
