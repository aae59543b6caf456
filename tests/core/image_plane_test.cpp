#include "core/image_plane.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

TEST_CASE("the convention is PLUS's: x along columns, y down rows, z out of the plane, origin in the first pixel",
          "[image]") {
  ImagePlane image;
  image.spacing = {0.1, 0.2};
  image.size = {380, 250};
  const RigidTransform identity;
  const ImagePoint origin = project(image, identity, Vec3::Zero(), Mat3::Zero());
  CHECK(origin.pixel == Eigen::Vector2d(0.0, 0.0));
  CHECK(origin.inside);
  const ImagePoint point = project(image, identity, Vec3(5.0, 7.0, -3.0), Mat3::Zero());
  CHECK((point.pixel - Eigen::Vector2d(50.0, 35.0)).norm() < 1e-12);
  CHECK(point.distance == -3.0);
  // A pixel reaches half a pixel beyond its centre.
  CHECK(project(image, identity, Vec3(-0.049, 0.0, 0.0), Mat3::Zero()).inside);
  CHECK_FALSE(project(image, identity, Vec3(-0.051, 0.0, 0.0), Mat3::Zero()).inside);
  CHECK(project(image, identity, Vec3(37.949, 49.89, 0.0), Mat3::Zero()).inside);
  CHECK_FALSE(project(image, identity, Vec3(37.951, 0.0, 0.0), Mat3::Zero()).inside);
  CHECK_FALSE(project(image, identity, Vec3(0.0, 49.91, 0.0), Mat3::Zero()).inside);
}

// A point of the image is put into space by homogeneous matrices, as PLUS writes them.
TEST_CASE("what is drawn at a pixel and lifted off the plane comes back to both", "[image]") {
  std::mt19937 generator(5);
  for (int k = 0; k < 50; ++k) {
    ImagePlane image;
    image.probe_T_image = {random_rotation(generator), 40.0 * random_vector(generator)};
    image.spacing = {0.05 + 0.01 * k, 0.3 - 0.005 * k};
    image.size = {640, 480};
    const RigidTransform tissue_T_probe{random_rotation(generator), 100.0 * random_vector(generator)};
    const auto matrix = [](const RigidTransform& t) {
      Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
      m.topLeftCorner<3, 3>() = t.rotation;
      m.topRightCorner<3, 1>() = t.translation;
      return m;
    };
    const double u = 640.0 * symmetric_random(generator), v = 480.0 * symmetric_random(generator);
    const double lift = 20.0 * symmetric_random(generator);
    const Eigen::Vector4d p = matrix(tissue_T_probe) * matrix(image.probe_T_image) *
                              Eigen::Vector4d(u * image.spacing.x(), v * image.spacing.y(), lift, 1.0);
    const ImagePoint point = project(image, tissue_T_probe, p.head<3>(), Mat3::Zero());
    CHECK((point.pixel - Eigen::Vector2d(u, v)).norm() < 1e-9);
    CHECK(point.distance == Approx(lift).margin(1e-10));
    CHECK(point.inside == (u >= -0.5 && u <= 639.5 && v >= -0.5 && v <= 479.5));
  }
}

TEST_CASE("covariance and ellipse are those of a cloud of projected points", "[image]") {
  std::mt19937 generator(8);
  std::normal_distribution<double> normal;
  ImagePlane image;
  image.probe_T_image = {random_rotation(generator), 10.0 * random_vector(generator)};
  image.spacing = {0.1, 0.25};
  const RigidTransform tissue_T_probe{random_rotation(generator), 50.0 * random_vector(generator)};
  const Mat3 root = random_matrix(generator);
  const Mat3 covariance = root * root.transpose();
  const Vec3 place = 30.0 * random_vector(generator);
  const ImagePoint claimed = project(image, tissue_T_probe, place, covariance);
  constexpr int kPoints = 200000;
  Eigen::Matrix2d cloud = Eigen::Matrix2d::Zero();
  double distance_square = 0.0;
  const Ellipse ellipse = ellipse_of(claimed.covariance);
  const Eigen::Vector2d major(std::cos(ellipse.angle), std::sin(ellipse.angle)), minor(-major.y(), major.x());
  int inside = 0;
  for (int k = 0; k < kPoints; ++k) {
    const Vec3 p = place + root * Vec3(normal(generator), normal(generator), normal(generator));
    const ImagePoint point = project(image, tissue_T_probe, p, Mat3::Zero());
    const Eigen::Vector2d off = point.pixel - claimed.pixel;
    cloud += off * off.transpose() / kPoints;
    distance_square += std::pow(point.distance - claimed.distance, 2) / kPoints;
    inside += std::pow(off.dot(major) / ellipse.major, 2) + std::pow(off.dot(minor) / ellipse.minor, 2) <= 5.991;
  }
  CHECK((cloud - claimed.covariance).norm() < 0.01 * claimed.covariance.norm());
  CHECK(std::sqrt(distance_square) == Approx(claimed.distance_sd).epsilon(0.01));
  CHECK(static_cast<double>(inside) / kPoints == Approx(0.95).margin(0.003));
  CHECK(ellipse.major > ellipse.minor);
}

TEST_CASE("ellipses of plain covariances", "[image]") {
  const auto of = [](double uu, double uv, double vv) {
    Eigen::Matrix2d c;
    c << uu, uv, uv, vv;
    return ellipse_of(c);
  };
  CHECK(of(9.0, 0.0, 4.0).major == Approx(3.0));
  CHECK(of(9.0, 0.0, 4.0).minor == Approx(2.0));
  CHECK(of(9.0, 0.0, 4.0).angle == Approx(0.0));
  CHECK(std::abs(of(4.0, 0.0, 9.0).angle) == Approx(std::numbers::pi / 2));
  CHECK(of(2.0, 1.0, 2.0).angle == Approx(std::numbers::pi / 4));
  CHECK(of(2.0, -1.0, 2.0).angle == Approx(-std::numbers::pi / 4));
  CHECK(of(0.0, 0.0, 0.0).major == 0.0);
  CHECK(of(1.0, 1.0, 1.0).minor == Approx(0.0).margin(1e-7));
}
