#include "daemon/confidence.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <random>

using namespace tissued;
using namespace tissued::daemon;

namespace {

// A turned ellipsoid with standard deviations 0.1, 0.5 and 2 mm.
Eigen::Matrix3d turned_covariance() {
  const Eigen::Matrix3d turn = Eigen::Quaterniond(0.8, 0.3, -0.4, 0.33).normalized().toRotationMatrix();
  return turn * Eigen::Vector3d(0.01, 0.25, 4.0).asDiagonal() * turn.transpose();
}

std::array<double, 6> packed(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

}  // namespace

TEST_CASE("The 95 % radius is the longest semi-axis") {
  // Chi-square tables: 7.815 at 95 % and three degrees of freedom.
  CHECK(radius_95({1, 0, 0, 1, 0, 1}).value() == Approx(std::sqrt(7.815)).epsilon(1e-4));
  CHECK(radius_95(packed(turned_covariance())).value() == Approx(2.0 * std::sqrt(7.815)).epsilon(1e-4));
}

TEST_CASE("An error is squared in units of its covariance") {
  CHECK(normalized_square(core::Vec3(2, 3, 5), {1, 0, 0, 9, 0, 25}).value() == Approx(4.0 + 1.0 + 1.0));
  // The eigenvectors of [2 1; 1 2] are (1, 1) with 3 and (1, -1) with 1.
  CHECK(normalized_square(core::Vec3(1, 1, 0), {2, 1, 0, 2, 0, 1}).value() == Approx(2.0 / 3.0));
  CHECK(normalized_square(core::Vec3(1, -1, 0), {2, 1, 0, 2, 0, 1}).value() == Approx(2.0));
}

TEST_CASE("No covariance claims nothing") {
  CHECK_FALSE(normalized_square(core::Vec3(1, 0, 0), {}));
  CHECK_FALSE(radius_95({}));
  protocol::TargetPrediction prediction;
  prediction.has_truth = true;
  CHECK_FALSE(inside_95(prediction));
}

TEST_CASE("95 of 100 normal samples lie in the ellipsoid") {
  const Eigen::Matrix3d covariance = turned_covariance();
  const Eigen::Matrix3d root = covariance.llt().matrixL();
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  protocol::TargetPrediction prediction;
  prediction.covariance = packed(covariance);
  prediction.has_truth = true;
  const int samples = 20000;
  int inside = 0;
  for (int i = 0; i < samples; ++i) {
    const Eigen::Vector3d unit(normal(random), normal(random), normal(random));
    const Eigen::Vector3d sample = root * unit;
    prediction.truth = {sample.x(), sample.y(), sample.z()};
    inside += inside_95(prediction).value() ? 1 : 0;
  }
  CHECK(inside / double(samples) == Approx(0.95).margin(0.006));  // four standard deviations of the count
}

TEST_CASE("Without truth there is no error") {
  protocol::TargetPrediction prediction;
  prediction.position = {1, 2, 3};
  CHECK_FALSE(error_of(prediction));
  prediction.has_truth = true;
  prediction.truth = {1, 5, 7};
  CHECK(error_of(prediction).value() == Approx(5.0));
}

TEST_CASE("Reasons are named, reserved ones too") {
  CHECK(reason_names(0).empty());
  CHECK(reason_names(protocol::kTrackerSilent | protocol::kPartialFrame) ==
        std::vector<std::string>{"tracker_silent", "partial_frame"});
  CHECK(reason_names(0x8000) == std::vector<std::string>{"unknown"});
}
