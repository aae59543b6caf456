// The global step's matrices, its factor and its held nodes against dense algebra.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "core/model.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr double kTimeStep = 0.01;

// K = M / dt^2 + L on the free nodes, rows in the factor's order.
Eigen::MatrixXd dense_system(const Model& model) {
  Eigen::MatrixXd k = Eigen::MatrixXd(model.laplacian()).selfadjointView<Eigen::Lower>();
  k.diagonal() += model.masses() / (kTimeStep * kTimeStep);
  std::vector<int> rows;
  for (int row = 0; row < model.system().free_count(); ++row) rows.push_back(model.system().node_of_row(row));
  return k(rows, rows);
}

using Rows = Eigen::Matrix<float, Eigen::Dynamic, 4, Eigen::RowMajor>;

Rows random_rows(int count, std::mt19937& generator) {
  Rows rows = Rows::Zero(count, 4);
  for (int i = 0; i < count; ++i) rows.row(i).head<3>() = random_vector(generator).cast<float>().transpose();
  return rows;
}

struct Constrained {
  Eigen::MatrixXd moves;   // (free x 3) mm
  Eigen::MatrixXd forces;  // (held x 3) mN
};

// Moves with the rows `held` prescribed, by elimination.
Constrained eliminate(const Eigen::MatrixXd& k, const Eigen::MatrixXd& residual, const std::vector<int>& held,
                      const Eigen::MatrixXd& wanted) {
  std::vector<int> open;
  for (int i = 0; i < k.rows(); ++i)
    if (std::find(held.begin(), held.end(), i) == held.end()) open.push_back(i);
  Constrained out;
  out.moves.resize(k.rows(), 3);
  const Eigen::MatrixXd right = residual(open, Eigen::all) - k(open, held) * wanted;
  const Eigen::MatrixXd solved = Eigen::MatrixXd(k(open, open)).ldlt().solve(right);
  out.moves(open, Eigen::all) = solved;
  out.moves(held, Eigen::all) = wanted;
  out.forces = Eigen::MatrixXd(k * out.moves - residual)(held, Eigen::all);
  return out;
}

}  // namespace

TEST_CASE("lumped masses add up to density times volume", "[global_step]") {
  const BoxSize size;
  const Scene scene = box_scene(size);
  const Eigen::VectorXd masses = lumped_masses(scene.mesh, 1.07);
  CHECK(masses.minCoeff() > 0);
  CHECK(masses.sum() == Approx(1.07e-6 * 1e3 * size.nx * size.ny * size.nz));
}

TEST_CASE("L vanishes on constants and measures the gradient of linear fields", "[global_step]") {
  const Scene scene = box_scene({});
  constexpr double kWeightScale = 3.0;
  const auto domains = strain_domains(scene.mesh, scene.material, Element::p1);
  const Eigen::MatrixXd l = Eigen::MatrixXd(weighted_laplacian(scene.mesh.node_count(), domains, kWeightScale))
                                .selfadjointView<Eigen::Lower>();
  CHECK((l * Eigen::VectorXd::Ones(l.rows())).cwiseAbs().maxCoeff() < 1e-10 * l.cwiseAbs().maxCoeff());
  std::mt19937 generator(31);
  const Vec3 slope = random_vector(generator);
  const Eigen::VectorXd field = scene.mesh.rest * slope;
  const double k = kWeightScale * (scene.material.bulk_modulus() + 4.0 / 3.0 * scene.material.shear_modulus());
  CHECK(field.dot(l * field) == Approx(k * 24e3 * slope.squaredNorm()));
}

TEST_CASE("the panels in single precision solve what dense algebra solves", "[global_step]") {
  const Model model(box_scene({5, 4, 3, 8.0}), Element::p1, 4.0, kTimeStep);
  std::mt19937 generator(32);
  const Rows residual = random_rows(model.system().free_count(), generator);
  Rows delta = residual;
  model.system().factor().panels().solve(delta.data());
  const Eigen::MatrixXd expected = dense_system(model).ldlt().solve(Eigen::MatrixXd(residual.cast<double>()));
  CHECK((delta.cast<double>() - expected).cwiseAbs().maxCoeff() < 1e-5 * expected.cwiseAbs().maxCoeff());
  CHECK(delta.col(3).cwiseAbs().maxCoeff() == 0.0f);
}

TEST_CASE("the factor solves in double in the order of the matrix", "[global_step]") {
  const Model model(box_scene({3, 3, 2, 8.0}), Element::p1, 4.0, kTimeStep);
  const int free = model.system().free_count();
  const Eigen::MatrixXd b = Eigen::MatrixXd::Identity(free, free);
  const Eigen::MatrixXd inverse = model.system().factor().solve(b);
  const std::vector<int>& order = model.system().factor().order();
  const Eigen::MatrixXd product = dense_system(model) * Eigen::MatrixXd(inverse(order, order));
  CHECK((product - b).cwiseAbs().maxCoeff() < 1e-10);
}

TEST_CASE("a matrix that is not positive definite is refused", "[global_step]") {
  SparseMatrix lower(2, 2);
  lower.insert(0, 0) = 1.0;
  lower.insert(1, 0) = 2.0;
  lower.insert(1, 1) = 1.0;
  lower.makeCompressed();
  CHECK_THROWS_AS(SparseCholesky(lower), ModelError);
}

TEST_CASE("held nodes move as prescribed and all else as elimination says, while pads come and go", "[held_nodes]") {
  const Scene scene = box_scene({5, 4, 3, 8.0});
  const Model model(scene, Element::p1, 4.0, kTimeStep);
  const std::vector<int> shared = shared_nodes(scene.mesh, "A1", "A2");
  REQUIRE(!shared.empty());
  const Eigen::MatrixXd k = dense_system(model);
  HeldNodes held(model.holdable());
  std::mt19937 generator(33);
  const std::vector<std::vector<std::uint8_t>> visits = {{1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 1}, {1, 0}, {0, 1}};
  for (const auto& groups : visits) {
    INFO("groups " << int(groups[0]) << int(groups[1]));
    held.hold(groups);
    std::size_t expected_count = 0;
    for (int p = 0; p < 2; ++p) expected_count += groups[p] ? model.pad_nodes()[p].size() : 0;
    if (groups[0] && groups[1]) expected_count -= shared.size();
    REQUIRE(held.count() == static_cast<int>(expected_count));
    std::vector<int> rows;
    Eigen::MatrixXd wanted(held.count(), 3);
    std::vector<Eigen::Vector4d> moves;
    for (int i = 0; i < held.count(); ++i) {
      rows.push_back(held.row(i));
      CHECK(model.system().node_of_row(held.row(i)) == held.node(i));
      wanted.row(i) = 2.0 * random_vector(generator).transpose();
      moves.push_back({wanted(i, 0), wanted(i, 1), wanted(i, 2), 0.0});
    }
    const Rows residual = random_rows(model.system().free_count(), generator);
    // Twice with the same task: the second time from the constraint forces of the first.
    for (int round = 0; round < 2; ++round) {
      Rows delta = residual;
      held.add_forces(delta.data());
      model.system().factor().panels().solve(delta.data());
      held.enforce(delta.data(), moves);
      const Constrained expected = eliminate(k, residual.leftCols<3>().cast<double>(), rows, wanted);
      CHECK((delta.leftCols<3>().cast<double>() - expected.moves).cwiseAbs().maxCoeff() <
            1e-5 * expected.moves.cwiseAbs().maxCoeff());
      for (int i = 0; i < held.count(); ++i)
        CHECK((held.force(i).head<3>().transpose() - expected.forces.row(i)).norm() < 1e-4 * expected.forces.norm());
    }
  }
}
