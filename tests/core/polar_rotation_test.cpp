#include "core/polar_rotation.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

// The proper rotation nearest to `a`, from Eigen's singular value decomposition.
Mat3 by_svd(const Mat3& a) {
  const Eigen::JacobiSVD<Mat3> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 sign = Mat3::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

}  // namespace

TEST_CASE("the polar rotation is that of the singular value decomposition", "[pbd]") {
  std::mt19937 generator(3);
  for (int i = 0; i < 2000; ++i) {
    const Mat3 a = std::pow(10.0, i % 7 - 3) * random_matrix(generator);
    const Eigen::JacobiSVD<Mat3> svd(a);
    // Next to a reflection with equal stretches the nearest rotation is not unique.
    const Vec3 s = svd.singularValues();
    if (a.determinant() < 0.0 && s[1] - s[2] < 0.05 * s[0]) continue;
    Eigen::Quaterniond rotation = Eigen::Quaterniond(random_rotation(generator));
    polar_rotation(a, rotation);
    CHECK((rotation.toRotationMatrix() - by_svd(a)).norm() < 1e-6);
  }
}

TEST_CASE("half a turn away, where Newton's method has no slope, it is found, too", "[pbd]") {
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Quaterniond rotation(Eigen::AngleAxisd(M_PI, Vec3::Unit(axis)));
    polar_rotation(Vec3(3.0, 2.0, 1.0).asDiagonal(), rotation);
    CHECK((rotation.toRotationMatrix() - Mat3::Identity()).norm() < 1e-6);
  }
}

TEST_CASE("what a matrix leaves open stays as it was", "[pbd]") {
  std::mt19937 generator(5);
  const Mat3 before = random_rotation(generator);
  Eigen::Quaterniond rotation(before);
  polar_rotation(Mat3::Zero(), rotation);
  CHECK((rotation.toRotationMatrix() - before).norm() < 1e-12);
  // A line along x that now lies along its image under `before`: every turn about it fits.
  polar_rotation(before.col(0) * Vec3::UnitX().transpose(), rotation);
  CHECK((rotation.toRotationMatrix() - before).norm() < 1e-6);
}

TEST_CASE("a matrix that is not finite makes a rotation that is not", "[pbd]") {
  Mat3 a = Mat3::Identity();
  a(1, 2) = std::numeric_limits<double>::quiet_NaN();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  polar_rotation(a, rotation);
  CHECK_FALSE(rotation.coeffs().allFinite());
}
