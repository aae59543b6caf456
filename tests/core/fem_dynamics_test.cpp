// Time steps of fem against the closed form of one mode's motion, and against a beam's frequency.
#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/fem_dynamics.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr double kAmplitude = 1e-4;  // mm: so small that the body is linear

FemOptions of_element(FemElement element) {
  FemOptions options;
  options.element = element;
  return options;
}

Eigen::MatrixXd dense(const FemPattern& pattern, const std::vector<double>& values) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(3 * pattern.node_count, 3 * pattern.node_count);
  for (int j = 0; j < 3 * pattern.node_count; ++j)
    for (int k = pattern.column[j]; k < pattern.column[j + 1]; ++k)
      out(pattern.row[k], j) = out(j, pattern.row[k]) = values[k];
  return out;
}

// One eigenmode of a small body, from dense matrices.
struct Mode {
  Eigen::VectorXd shape;  // (3n), largest entry 1
  double omega;           // rad/s
};

Mode mode_of(FemEquilibrium& equilibrium, int index) {
  const FemModel& model = equilibrium.model();
  const FemState rest = rest_state(model);
  Eigen::VectorXd residual;
  std::vector<double> stiffness, mass;
  equilibrium.terms(rest.x, 0.0, rest.history, residual, &stiffness);
  FemAssembler(model.pattern(), model.masses(), 1).evaluate(rest.x, 0.0, FemHistory(1), residual, &mass);
  std::vector<int> free;
  for (int i = 0; i < model.mesh().node_count(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      if (!model.fixed()[i]) free.push_back(3 * i + axis);
  const Eigen::MatrixXd k = dense(model.pattern(), stiffness)(free, free);
  const Eigen::MatrixXd m = dense(model.pattern(), mass)(free, free);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(k, m);
  Mode mode{Eigen::VectorXd::Zero(rest.x.size()), std::sqrt(eigen.eigenvalues()[index])};
  for (std::size_t i = 0; i < free.size(); ++i)
    mode.shape[free[i]] = eigen.eigenvectors()(static_cast<Eigen::Index>(i), index);
  mode.shape /= mode.shape.cwiseAbs().maxCoeff();
  return mode;
}

// The mode's coordinate after every step, let go from kAmplitude; the first entry is 1.
std::vector<double> swing(FemEquilibrium& equilibrium, const Mode& mode, const TimeScheme& scheme,
                          const RayleighDamping& damping, double dt, int steps) {
  const FemModel& model = equilibrium.model();
  FemDynamics dynamics(equilibrium, scheme, damping);
  FemState state = rest_state(model);
  state.x += kAmplitude * mode.shape;
  const std::vector<PadInput> pads(2);
  dynamics.start(state, {pads});
  FemControl control;
  control.tolerance = 1e-11;
  std::vector<double> coordinate{1.0};
  for (int n = 0; n < steps; ++n) {
    REQUIRE(dynamics.step(state, {pads}, dt, control).converged);
    coordinate.push_back((state.x - model.rest()).dot(mode.shape) / mode.shape.squaredNorm() / kAmplitude);
  }
  return coordinate;
}

TimeScheme alpha(double radius) { return {TimeScheme::Kind::generalized_alpha, radius}; }

}  // namespace

TEST_CASE("generalized-alpha follows a mode to second order, whatever its damping", "[fem]") {
  const double radius = GENERATE(0.0, 0.5, 1.0);
  const FemModel model(box_scene({2, 2, 2, 10.0}), of_element(FemElement::p1));
  FemEquilibrium equilibrium(model, 1);
  const Mode mode = mode_of(equilibrium, 2);
  const double period = 2.0 * M_PI / mode.omega;
  const auto error = [&](int steps) {
    const double dt = 0.9 * period / steps;
    const std::vector<double> q = swing(equilibrium, mode, alpha(radius), {}, dt, steps);
    double worst = 0.0;
    for (int n = 0; n <= steps; ++n) worst = std::max(worst, std::abs(q[n] - std::cos(mode.omega * n * dt)));
    return worst;
  };
  const double coarse = error(40), fine = error(80);
  INFO("errors " << coarse << ", " << fine);
  CHECK(fine < 0.02);
  CHECK(std::log2(coarse / fine) == Approx(2.0).margin(0.15));
}

TEST_CASE("a damped mode decays as Rayleigh's damping says", "[fem]") {
  const FemModel model(box_scene({2, 2, 2, 10.0}), of_element(FemElement::p2));
  FemEquilibrium equilibrium(model, 1);
  const Mode mode = mode_of(equilibrium, 0);
  const RayleighDamping damping{0.1 * mode.omega, 0.06 / mode.omega};
  const double ratio = 0.5 * (damping.mass / mode.omega + damping.stiffness * mode.omega);  // 0.08
  const double damped = mode.omega * std::sqrt(1.0 - ratio * ratio);
  const int steps = 200;
  const double dt = 2.0 * 2.0 * M_PI / mode.omega / steps;
  const std::vector<double> q = swing(equilibrium, mode, alpha(0.9), damping, dt, steps);
  double worst = 0.0;
  for (int n = 0; n <= steps; ++n) {
    const double t = n * dt;
    const double exact =
        std::exp(-ratio * mode.omega * t) * (std::cos(damped * t) + ratio * mode.omega / damped * std::sin(damped * t));
    worst = std::max(worst, std::abs(q[n] - exact));
  }
  CHECK(worst < 2e-3);
}

TEST_CASE("implicit Euler damps a mode by its formula", "[fem]") {
  const FemModel model(box_scene({2, 2, 2, 10.0}), of_element(FemElement::p1));
  FemEquilibrium equilibrium(model, 1);
  const Mode mode = mode_of(equilibrium, 0);
  const double dt = 0.3 / mode.omega;
  const std::vector<double> q = swing(equilibrium, mode, {TimeScheme::Kind::implicit_euler, 0.0}, {}, dt, 30);
  // x' (1 + w^2 dt^2) = 2 x - x_before, whose roots have modulus 1 / sqrt(1 + w^2 dt^2).
  double before = 1.0, now = 1.0;
  const double stiff = 1.0 + 0.09;
  for (std::size_t n = 1; n < q.size(); ++n) {
    const double next = (2.0 * now - before) / stiff;
    before = now;
    now = next;
    CHECK(q[n] == Approx(now).margin(1e-5));
  }
}

TEST_CASE("without damping generalized-alpha keeps a mode's amplitude", "[fem]") {
  const FemModel model(box_scene({2, 2, 2, 10.0}), of_element(FemElement::p1));
  FemEquilibrium equilibrium(model, 1);
  const Mode mode = mode_of(equilibrium, 0);
  const std::vector<double> q = swing(equilibrium, mode, alpha(1.0), {}, 0.3 / mode.omega, 150);
  CHECK(*std::max_element(q.end() - 40, q.end()) == Approx(1.0).margin(0.02));
  const std::vector<double> damped = swing(equilibrium, mode, alpha(0.0), {}, 0.3 / mode.omega, 150);
  CHECK(*std::max_element(damped.end() - 40, damped.end()) < 0.9);
}

TEST_CASE("a cantilever of quadratic tetrahedra swings at Timoshenko's frequency", "[fem]") {
  constexpr double kLength = 100.0, kWidth = 10.0;
  Scene scene = box_scene({2, 2, 20, 5.0});
  scene.material = {6.0, 0.0, 1.0};
  scene.targets.clear();
  scene.markers.clear();
  const FemModel model(scene, of_element(FemElement::p2));
  FemEquilibrium equilibrium(model, 1);
  const FemState rest = rest_state(model);
  Eigen::VectorXd residual, product, shape = Eigen::VectorXd::Zero(rest.x.size());
  std::vector<double> stiffness, mass;
  equilibrium.terms(rest.x, 0.0, rest.history, residual, &stiffness);
  FemAssembler(model.pattern(), model.masses(), 1).evaluate(rest.x, 0.0, FemHistory(1), residual, &mass);
  REQUIRE(equilibrium.factor().factorize(stiffness, model.fixed()));
  for (int i = 0; i < model.mesh().node_count(); ++i) shape[3 * i] = std::pow(model.mesh().rest(i, 2), 2);
  double square = 0.0;
  for (int k = 0; k < 30; ++k) {  // inverse iteration
    model.pattern().multiply(mass, shape, product);
    const Eigen::VectorXd next = equilibrium.factor().solve(product);
    square = shape.dot(product) / next.dot(product);
    shape = next / next.norm();
  }
  // Euler and Bernoulli's first frequency, 1.8751^2 sqrt(EI / (rho A L^4)), corrected for shear and rotary inertia by
  // Dunkerley: 1/w^2 = 1/w_b^2 + 1/w_s^2, w_s of a clamped shear beam; rotary inertia adds its share of w_b.
  const double e = 6.0, g = 3.0, rho = 1e-6, area = kWidth * kWidth, inertia = std::pow(kWidth, 4) / 12.0;
  const double bending = std::pow(1.87510407, 4) * e * inertia / (rho * area * std::pow(kLength, 4));
  const double shear = std::pow(0.5 * M_PI / kLength, 2) * 5.0 / 6.0 * g / rho;
  const double rotary =
      4.65 * inertia / (area * kLength * kLength);  // integral of phi'^2 over that of phi^2, first mode
  CHECK(square == Approx(1.0 / (1.0 / bending + 1.0 / shear + rotary / bending)).epsilon(0.01));
}
