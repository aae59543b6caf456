#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <random>

#include "core/diagnosis/likelihood.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using testing::symmetric_random;

namespace {

constexpr int kChannels = 4, kParameters = 3;

TrialResidual random_trial(int index, int frames, std::mt19937& generator) {
  TrialResidual trial;
  trial.trial = index;
  trial.residual.resize(frames, kChannels);
  trial.load.resize(frames);
  trial.derivatives.assign(kParameters, RowMatrix(frames, kChannels));
  for (int f = 0; f < frames; ++f) {
    trial.load[f] = std::abs(symmetric_random(generator));
    for (int c = 0; c < kChannels; ++c) {
      trial.residual(f, c) = symmetric_random(generator);
      for (RowMatrix& derivative : trial.derivatives) derivative(f, c) = symmetric_random(generator);
    }
  }
  trial.residual(2, 1) = std::numeric_limits<double>::quiet_NaN();
  return trial;
}

ErrorModel random_errors(std::mt19937& generator) {
  ErrorModel errors;
  errors.noise = Eigen::VectorXd::Constant(kChannels, 0.2);
  errors.offset = Eigen::VectorXd::Constant(kChannels, 0.5);
  errors.discretisation.resize(2, kChannels);
  errors.bend.resize(2, kChannels);
  for (int c = 0; c < kChannels; ++c)
    for (int k = 0; k < 2; ++k) {
      errors.discretisation(k, c) = std::abs(symmetric_random(generator));
      errors.bend(k, c) = std::abs(symmetric_random(generator));
    }
  return errors;
}

}  // namespace

TEST_CASE("normal equations are those of the whole covariance matrix", "[diagnosis]") {
  std::mt19937 generator(3);
  const ErrorModel errors = random_errors(generator);
  const std::vector<TrialResidual> trials{random_trial(0, 9, generator), random_trial(1, 7, generator)};
  const std::vector<const TrialResidual*> pointers{&trials[0], &trials[1]};
  const NormalEquations equations = normal_equations(errors, pointers);

  double chi_square = 0.0;
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(kParameters);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(kParameters, kParameters);
  int count = 0;
  for (int c = 0; c < kChannels; ++c) {
    std::vector<std::pair<int, int>> rows;  // trial, frame
    for (int k = 0; k < 2; ++k)
      for (int f = 0; f < trials[k].residual.rows(); ++f)
        if (std::isfinite(trials[k].residual(f, c))) rows.emplace_back(k, f);
    const auto n = static_cast<Eigen::Index>(rows.size());
    Eigen::MatrixXd covariance(n, n), jacobian(n, kParameters);
    Eigen::VectorXd residual(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto [k, f] = rows[i];
      residual[i] = trials[k].residual(f, c);
      for (int j = 0; j < kParameters; ++j) jacobian(i, j) = trials[k].derivatives[j](f, c);
      for (Eigen::Index m = 0; m < n; ++m) {
        const auto [k2, f2] = rows[m];
        covariance(i, m) = errors.offset[c] * errors.offset[c] + (i == m ? errors.noise[c] * errors.noise[c] : 0.0);
        if (k != k2) continue;
        const double load = trials[k].load[f], load2 = trials[k].load[f2];
        covariance(i, m) += std::pow(errors.discretisation(k, c), 2) * load * load2;
        covariance(i, m) += std::pow(errors.bend(k, c), 2) * 16.0 * load * (1.0 - load) * load2 * (1.0 - load2);
      }
    }
    const Eigen::MatrixXd inverse = covariance.inverse();
    chi_square += residual.dot(inverse * residual);
    gradient += jacobian.transpose() * inverse * residual;
    normal += jacobian.transpose() * inverse * jacobian;
    count += static_cast<int>(n);
  }
  CHECK(equations.count == count);
  CHECK(equations.chi_square == Approx(chi_square));
  CHECK((equations.gradient - gradient).norm() < 1e-9 * gradient.norm());
  CHECK((equations.normal - normal).norm() < 1e-9 * normal.norm());
}

TEST_CASE("constants and what goes with the load are told apart from structure", "[diagnosis]") {
  std::mt19937 generator(5);
  ErrorModel errors;
  errors.noise = Eigen::VectorXd::Constant(3, 0.1);
  errors.offset = Eigen::VectorXd::Constant(3, 0.5);
  errors.discretisation = RowMatrix::Constant(1, 3, 0.5);
  TrialResidual trial;
  constexpr int kFrames = 600;
  trial.residual.resize(kFrames, 3);
  trial.load.resize(kFrames);
  for (int f = 0; f < kFrames; ++f) {
    trial.load[f] = std::abs(std::sin(0.02 * f));
    for (int c = 0; c < 3; ++c) {
      double noise = 0.0;
      for (int i = 0; i < 12; ++i) noise += 0.5 * symmetric_random(generator);
      trial.residual(f, c) = 0.3 - 0.4 * trial.load[f] + 0.1 * noise;
    }
  }
  const TrialResidual* only = &trial;
  const Nuisances known = nuisances(errors, {&only, 1});
  CHECK(known.offset[0] == Approx(0.3).margin(0.03));
  CHECK(known.discretisation(0, 0) == Approx(-0.4).margin(0.04));
  const Channels channels{1, 0, 0};
  CHECK(structure_left(errors, channels, {&only, 1})[0] < 1.3);
  // A drift that is a third of the noise in every frame.
  for (int f = 0; f < kFrames; ++f) trial.residual(f, 1) += 0.033 * std::sin(0.13 * f);
  trial.residual.col(0) = trial.residual.col(2) = trial.residual.col(1);
  CHECK(structure_left(errors, channels, {&only, 1})[0] > 1.3);
}

TEST_CASE("noise is seen beneath slow motion", "[diagnosis]") {
  std::mt19937 generator(7);
  RecordedTrial trial;
  trial.seen.resize(800, 2);
  for (int f = 0; f < 800; ++f) {
    double noise = 0.0;
    for (int i = 0; i < 12; ++i) noise += 0.5 * symmetric_random(generator);
    trial.seen(f, 0) = 10.0 * std::sin(0.01 * f) + 0.2 * noise;
    trial.seen(f, 1) = std::numeric_limits<double>::quiet_NaN();
  }
  const Eigen::VectorXd noise = noise_seen({&trial, 1}, Eigen::Vector2d(0.1, 0.1));
  CHECK(noise[0] == Approx(0.2).epsilon(0.1));
  CHECK(noise[1] == 0.1);
}
