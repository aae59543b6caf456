// The local step (10) against its optimality condition and against a brute-force minimisation over all nine entries of
// z.
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "core/domain_blocks.hpp"
#include "core/neo_hookean.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

using Vec9 = Eigen::Matrix<double, 9, 1>;
using Mat9 = Eigen::Matrix<double, 9, 9>;

// Tetrahedra that share no node, so that each can be given a deformation gradient of its own.
TetMesh loose_tetrahedra(int count, std::mt19937& generator) {
  TetMesh mesh;
  mesh.rest.resize(4 * count, 3);
  for (int e = 0; e < count; ++e) {
    mesh.rest.row(4 * e) = 5.0 * random_vector(generator).transpose();
    Mat3 edges = 6.0 * Mat3::Identity() + 2.0 * random_matrix(generator);
    for (int a = 0; a < 3; ++a) mesh.rest.row(4 * e + a + 1) = mesh.rest.row(4 * e) + edges.col(a).transpose();
    mesh.tets.push_back({4 * e, 4 * e + 1, 4 * e + 2, 4 * e + 3});
  }
  return mesh;
}

struct LocalAnswer {
  std::vector<Mat3> z;
  LocalStepResult result;
  std::vector<CornerForce> forces;
};

// Runs the local step on given gradients and duals; z is recovered from the new dual, u_new = F + u_old - z.
LocalAnswer run_local_step(const TetMesh& mesh, const Material& material, double weight_scale,
                           const std::vector<Mat3>& f, const std::vector<Mat3>& u) {
  const DomainBlocks blocks = make_domain_blocks(strain_domains(mesh, material, Element::p1), weight_scale);
  std::vector<DomainState> states(static_cast<std::size_t>(blocks.count()));
  reset_domain_states(states);
  NodeField x = NodeField::Zero(mesh.node_count(), 4);
  for (int i = 0; i < mesh.node_count(); ++i) x.row(i).head<3>() = (f[i / 4] * mesh.node(i)).transpose();
  for (std::size_t e = 0; e < f.size(); ++e)
    for (int i = 0; i < 9; ++i) states[e / kLanes].u[i][e % kLanes] = u[e](i / 3, i % 3);
  LocalAnswer answer;
  answer.forces.resize(blocks.corners.size());
  answer.result = local_step(blocks, 0, blocks.count(), x.data(), states.data(), answer.forces.data());
  for (std::size_t e = 0; e < f.size(); ++e) {
    Mat3 dual;
    for (int i = 0; i < 9; ++i) dual(i / 3, i % 3) = states[e / kLanes].u[i][e % kLanes];
    answer.z.push_back(f[e] + u[e] - dual);
  }
  return answer;
}

double objective(const Material& m, double k, const Mat3& p, const Mat3& z) {
  return strain_energy_density(m, z) + 0.5 * k * (z - p).squaredNorm();
}

Mat3 objective_gradient(const Material& m, double k, const Mat3& p, const Mat3& z) {
  return first_piola(m, z) + k * (z - p);
}

// Newton in nine unknowns, Hessian by differences, eigenvalues made positive, halving steps.
Mat3 minimise_from(const Material& m, double k, const Mat3& p, Mat3 z) {
  for (int iteration = 0; iteration < 100; ++iteration) {
    const Mat3 gradient = objective_gradient(m, k, p, z);
    if (gradient.norm() < 1e-10 * k) break;
    Mat9 hessian;
    const double h = 1e-6 * std::min(1.0, std::cbrt(z.determinant()));
    for (int i = 0; i < 9; ++i) {
      Mat3 plus = z, minus = z;
      plus.data()[i] += h;
      minus.data()[i] -= h;
      const Mat3 column = (objective_gradient(m, k, p, plus) - objective_gradient(m, k, p, minus)) / (2.0 * h);
      hessian.col(i) = Eigen::Map<const Vec9>(column.data());
    }
    const Eigen::SelfAdjointEigenSolver<Mat9> eigen(0.5 * (hessian + hessian.transpose()));
    const Vec9 positive = eigen.eigenvalues().cwiseAbs().cwiseMax(1e-2 * k);
    const Vec9 move = -(eigen.eigenvectors() * positive.cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose() *
                        Eigen::Map<const Vec9>(gradient.data()));
    const double before = objective(m, k, p, z);
    double step = 1.0;
    while (step > 1e-14) {
      const Mat3 trial = z + step * Eigen::Map<const Mat3>(move.data());
      if (objective(m, k, p, trial) < before) {
        z = trial;
        break;
      }
      step *= 0.5;
    }
    if (step <= 1e-14) break;
  }
  return z;
}

struct Regime {
  const char* name;
  double low, high;     // of the stretches
  bool inverted, flat;  // smallest stretch negated, or made 1e-3 of itself
  double dual;          // size of the random dual
};

constexpr Regime kRegimes[] = {
    {"moderate", 0.8, 1.25, false, false, 0.1},   {"large", 0.4, 2.5, false, false, 0.1},
    {"compressed", 0.1, 0.5, false, false, 0.02}, {"inverted", 0.5, 1.5, true, false, 0.02},
    {"nearly flat", 0.7, 1.4, false, true, 0.0},
};

std::vector<Mat3> gradients_of(const Regime& regime, int count, std::mt19937& generator) {
  std::vector<Mat3> f;
  for (int e = 0; e < count; ++e) {
    Vec3 stretch;
    for (double& s : stretch)
      s = regime.low * std::pow(regime.high / regime.low, 0.5 + 0.5 * symmetric_random(generator));
    if (regime.inverted) stretch[2] *= -0.4;
    if (regime.flat) stretch[2] *= 1e-3;
    f.push_back(random_rotation(generator) * stretch.asDiagonal() * random_rotation(generator).transpose());
  }
  return f;
}

std::vector<Mat3> duals_of(const Regime& regime, int count, std::mt19937& generator) {
  std::vector<Mat3> u;
  for (int e = 0; e < count; ++e) u.push_back(regime.dual * random_matrix(generator));
  return u;
}

}  // namespace

TEST_CASE("first_piola is the derivative of strain_energy_density", "[local_step]") {
  std::mt19937 generator(1);
  const Material material;
  for (int trial = 0; trial < 50; ++trial) {
    Mat3 f = Mat3::Identity() + 0.3 * random_matrix(generator);
    if (f.determinant() < 0.1) continue;
    const Mat3 stress = first_piola(material, f);
    for (int i = 0; i < 9; ++i) {
      constexpr double h = 1e-6;
      Mat3 plus = f, minus = f;
      plus.data()[i] += h;
      minus.data()[i] -= h;
      const double slope = (strain_energy_density(material, plus) - strain_energy_density(material, minus)) / (2.0 * h);
      CHECK(slope == Approx(stress.data()[i]).margin(1e-6));
    }
  }
}

TEST_CASE("energy (11) at rest, turned, and in stretches known by hand", "[local_step]") {
  std::mt19937 generator(2);
  const Material material{6.0, 0.45, 1.0};
  const double mu = material.shear_modulus(), kappa = material.bulk_modulus();
  CHECK(mu == Approx(6.0 / 2.9));
  CHECK(kappa == Approx(20.0));
  CHECK(strain_energy_density(material, Mat3::Identity()) == 0.0);
  CHECK(first_piola(material, Mat3::Identity()).norm() < 1e-14);
  const Mat3 turned = random_rotation(generator);
  CHECK(std::abs(strain_energy_density(material, turned)) < 1e-13);
  CHECK(first_piola(material, turned).norm() < 1e-12);
  // Swollen evenly by 1.1: shape does not change, so only volume is paid for.
  const double dilation = 1.1 * 1.1 * 1.1 - 1.0;
  CHECK(strain_energy_density(material, 1.1 * Mat3::Identity()) == Approx(0.5 * kappa * dilation * dilation));
  // Pure shear 2, 1/2, 1: volume does not change, so only shape is paid for.
  CHECK(strain_energy_density(material, Vec3(2.0, 0.5, 1.0).asDiagonal()) ==
        Approx(0.5 * mu * (4.0 + 0.25 + 1.0 - 3.0)));
  CHECK(std::isinf(strain_energy_density(material, Vec3(1, 1, -1).asDiagonal())));
}

TEST_CASE("the local step solves (10) to its optimality condition, whatever the element looks like", "[local_step]") {
  constexpr int kCount = 61;  // not a multiple of the lanes
  for (const double poisson : {0.3, 0.45, 0.49}) {
    const Material material{6.0, poisson, 1.0};
    for (const double weight_scale : {1.0, 4.0}) {
      const double k = weight_scale * (material.bulk_modulus() + 4.0 / 3.0 * material.shear_modulus());
      for (const Regime& regime : kRegimes) {
        std::mt19937 generator(3);
        const TetMesh mesh = loose_tetrahedra(kCount, generator);
        const auto f = gradients_of(regime, kCount, generator), u = duals_of(regime, kCount, generator);
        const LocalAnswer answer = run_local_step(mesh, material, weight_scale, f, u);
        INFO(regime.name << ", nu " << poisson << ", weight scale " << weight_scale);
        CHECK(answer.result.unconverged == 0);
        double worst = 0.0, worst_excess = 0.0;
        int inverted = 0;
        for (int e = 0; e < kCount; ++e) {
          const Mat3 p = f[e] + u[e], z = answer.z[e];
          inverted += f[e].determinant() <= 0;
          REQUIRE(z.determinant() > 0);
          const Mat3 stress = first_piola(material, z);
          worst = std::max(worst, (stress + k * (z - p)).norm() / (stress.norm() + k * p.norm()));
          double least = objective(material, k, p, z);
          const double ours = least;
          for (const Mat3& start :
               {Mat3(Mat3::Identity()), Mat3(random_rotation(generator)), Mat3(0.3 * random_rotation(generator)), z})
            least = std::min(least, objective(material, k, p, minimise_from(material, k, p, start)));
          worst_excess = std::max(worst_excess, (ours - least) / k);
        }
        CHECK(worst < 1e-7);
        CHECK(worst_excess < 1e-9);
        CHECK(answer.result.inverted == inverted);
      }
    }
  }
}

TEST_CASE("corner forces are minus D^T W^2 (Dx - z + u) and sum to nothing", "[local_step]") {
  std::mt19937 generator(5);
  const Material material;
  constexpr int kCount = 11;
  constexpr double kWeightScale = 2.0;
  const double k = kWeightScale * (material.bulk_modulus() + 4.0 / 3.0 * material.shear_modulus());
  const TetMesh mesh = loose_tetrahedra(kCount, generator);
  const auto f = gradients_of(kRegimes[0], kCount, generator), u = duals_of(kRegimes[0], kCount, generator);
  const LocalAnswer answer = run_local_step(mesh, material, kWeightScale, f, u);
  double primal = 0.0;
  for (int e = 0; e < kCount; ++e) {
    Mat3 edges;
    for (int a = 0; a < 3; ++a) edges.col(a) = mesh.node(4 * e + a + 1) - mesh.node(4 * e);
    const double volume = edges.determinant() / 6.0;
    primal = std::max(primal, (f[e] - answer.z[e]).norm() * std::cbrt(6.0 * volume));
    // The new dual is F + u - z.
    const Mat3 gap = 2.0 * (f[e] - answer.z[e]) + u[e];
    const Mat3 corners = -k * volume * gap * edges.inverse().transpose();
    Vec3 sum = Vec3::Zero();
    for (int a = 0; a < 4; ++a) {
      Vec3 force;
      for (int axis = 0; axis < 3; ++axis) force[axis] = answer.forces[4 * (e / kLanes) + a].force[axis][e % kLanes];
      sum += force;
      if (a > 0) CHECK((force - corners.col(a - 1)).norm() < 1e-9 * (1.0 + corners.norm()));
    }
    CHECK(sum.norm() < 1e-9 * (1.0 + corners.norm()));
  }
  CHECK(answer.result.primal == Approx(primal).epsilon(1e-9));
}
