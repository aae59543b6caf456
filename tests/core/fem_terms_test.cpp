// Every energy against its residual, every residual against its tangent, and both against what was written elsewhere.
#include <catch2/catch.hpp>

#include "core/fem_assembler.hpp"
#include "core/fem_gravity.hpp"
#include "core/fem_inertia.hpp"
#include "core/fem_model.hpp"
#include "core/fem_neo_hookean.hpp"
#include "core/neo_hookean.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

Scene small_scene() {
  Scene scene = box_scene({2, 2, 1, 10.0});
  scene.gravity = Vec3(0.3, -0.5, -1.0);
  scene.material.density = 1.3;
  return scene;
}

Eigen::VectorXd disturbed(const FemModel& model, double size, unsigned seed) {
  std::mt19937 generator(seed);
  Eigen::VectorXd x = model.rest();
  for (double& entry : x) entry += size * symmetric_random(generator);
  return x;
}

struct Evaluated {
  double energy;
  Eigen::VectorXd residual;
  std::vector<double> values;
};

Evaluated evaluate(FemAssembler& assembler, const FemHistory& history, const Eigen::VectorXd& x) {
  Evaluated out;
  out.energy = assembler.evaluate(x, 0.0, history, out.residual, &out.values);
  return out;
}

void check_derivatives(const FemModel& model, const std::vector<std::unique_ptr<FemTerm>>& terms) {
  constexpr double kStep = 1e-5;
  FemAssembler assembler(model.pattern(), terms, 1);
  FemHistory history(terms.size());
  const Eigen::VectorXd x = disturbed(model, 1.0, 5);
  const Evaluated at = evaluate(assembler, history, x);
  REQUIRE(std::isfinite(at.energy));
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Eigen::VectorXd way = disturbed(model, 1.0, 10 + seed) - model.rest();
    const Evaluated plus = evaluate(assembler, history, x + kStep * way);
    const Evaluated minus = evaluate(assembler, history, x - kStep * way);
    const double slope = (plus.energy - minus.energy) / (2.0 * kStep);
    CHECK(at.residual.dot(way) == Approx(slope).epsilon(1e-6).margin(1e-6));
    Eigen::VectorXd product;
    model.pattern().multiply(at.values, way, product);
    const Eigen::VectorXd difference = (plus.residual - minus.residual) / (2.0 * kStep);
    CHECK((product - difference).norm() < 1e-7 * (1.0 + product.norm()));
  }
}

}  // namespace

TEST_CASE("energy, residual and tangent of the body are derivatives of each other", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const Scene scene = small_scene();
  FemOptions options;
  options.element = element;
  const FemModel model(scene, options);
  check_derivatives(model, model.terms());
  check_derivatives(model, model.masses());
}

TEST_CASE("the lane law is equation (11), inverted points included", "[fem]") {
  const Material material{7.0, 0.42, 1.0};
  const FemNeoHookean law(material);
  std::mt19937 generator(4);
  PointDeformation deformation;
  std::array<Mat3, kPointLanes> f;
  for (int l = 0; l < kPointLanes; ++l) {
    f[l] = Mat3::Identity() + 0.3 * random_matrix(generator);
    if (l == 3) f[l].col(0) *= -1.0;
    for (int k = 0; k < 9; ++k) deformation.f[k][l] = f[l](k / 3, k % 3);
  }
  PointResponse response{};
  law.add({}, deformation, true, response);
  for (int l = 0; l < kPointLanes; ++l) {
    if (!(f[l].determinant() > 0)) {
      CHECK(std::isinf(response.energy[l]));
      continue;
    }
    CHECK(response.energy[l] == Approx(strain_energy_density(material, f[l])));
    const Mat3 stress = first_piola(material, f[l]);
    for (int k = 0; k < 9; ++k) CHECK(response.stress[k][l] == Approx(stress(k / 3, k % 3)).margin(1e-12));
  }
  CHECK(std::isinf(response.energy[3]));
}

TEST_CASE("derivatives by a term's parameters are those of differences", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const Scene scene = small_scene();
  FemOptions options;
  options.element = element;
  const FemModel model(scene, options);
  const Eigen::VectorXd x = disturbed(model, 1.0, 6);
  int checked = 0;
  for (const auto* group : {&model.terms(), &model.masses()}) {
    FemAssembler assembler(model.pattern(), *group, 1);
    const FemHistory history(group->size());
    for (std::size_t t = 0; t < group->size(); ++t) {
      FemTerm& term = *(*group)[t];
      for (std::size_t k = 0; k < term.parameters().size(); ++k, ++checked) {
        const int index = static_cast<int>(k);
        const double value = term.parameter(index), step = 1e-5;
        Eigen::VectorXd exact, plus, minus;
        assembler.differentiate(static_cast<int>(t), index, x, 0.0, history, exact);
        term.set_parameter(index, value + step);
        assembler.evaluate(x, 0.0, history, plus, nullptr);
        term.set_parameter(index, value - step);
        assembler.evaluate(x, 0.0, history, minus, nullptr);
        term.set_parameter(index, value);
        INFO(term.name() << " " << term.parameters()[k].name);
        CHECK(exact.norm() > 0.0);
        CHECK((exact - (plus - minus) / (2.0 * step)).norm() < 1e-6 * exact.norm());
      }
    }
  }
  CHECK(checked == 7);  // two moduli, gravity and density, density of inertia
}

TEST_CASE("weight and mass of the body add up to density times volume", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const auto mass = GENERATE(MassMatrix::consistent, MassMatrix::lumped);
  const Scene scene = small_scene();
  FemOptions options;
  options.element = element;
  options.mass = mass;
  const FemModel model(scene, options);
  FemAssembler inertia(model.pattern(), model.masses(), 1);
  Eigen::VectorXd push(3 * model.mesh().node_count()), momentum;
  for (int i = 0; i < model.mesh().node_count(); ++i) push.segment<3>(3 * i) = Vec3(1.0, 2.0, -1.0);
  inertia.evaluate(push, 0.0, FemHistory(1), momentum, nullptr);
  Vec3 total = Vec3::Zero(), weight = Vec3::Zero();
  for (int i = 0; i < model.mesh().node_count(); ++i) total += momentum.segment<3>(3 * i);
  const double kilograms = 1.3e-6 * 20.0 * 20.0 * 10.0;
  CHECK((total - kilograms * Vec3(1.0, 2.0, -1.0)).norm() < 1e-15);
  std::vector<std::unique_ptr<FemTerm>> gravity;
  gravity.push_back(std::make_unique<FemGravity>(model.mesh(), scene.gravity, 1.3));
  FemAssembler weigh(model.pattern(), gravity, 1);
  Eigen::VectorXd force;
  weigh.evaluate(push, 0.0, FemHistory(1), force, nullptr);
  for (int i = 0; i < model.mesh().node_count(); ++i) weight -= force.segment<3>(3 * i);
  CHECK((weight - kilograms * 9806.65 * scene.gravity).norm() < 1e-10);
}
