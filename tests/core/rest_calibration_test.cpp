// Rigid registration and marker offsets against what they were made from.
#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "core/rest_calibration.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

std::vector<Vec3> cloud(int count, std::mt19937& generator) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) points.push_back(80.0 * random_vector(generator));
  return points;
}

std::vector<Vec3> moved(const RigidTransform& transform, const std::vector<Vec3>& points) {
  std::vector<Vec3> out;
  for (const Vec3& p : points) out.push_back(transform(p));
  return out;
}

RigidTransform random_pose(std::mt19937& generator) {
  return {random_rotation(generator), 900.0 * random_vector(generator)};
}

// Standard deviation 1 a component, from twelve uniform numbers.
Vec3 normal_vector(std::mt19937& generator) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < 12; ++i) sum += 0.5 * random_vector(generator);
  return sum;
}

}  // namespace

TEST_CASE("register_rigid finds any rotation and translation again", "[rest_calibration]") {
  std::mt19937 generator(41);
  for (int trial = 0; trial < 50; ++trial) {
    const RigidTransform truth = random_pose(generator);
    const auto tracker = cloud(3 + trial % 6, generator);
    const Registration found = register_rigid(tracker, moved(truth, tracker));
    CHECK(found.determined);
    CHECK(found.points == 3 + trial % 6);
    CHECK((found.tissue_from_tracker.rotation - truth.rotation).norm() < 1e-10);
    CHECK((found.tissue_from_tracker.translation - truth.translation).norm() < 1e-8);
    CHECK(found.residual_max < 1e-8);
    const Vec3 p = tracker[0];
    CHECK((found.tissue_from_tracker.inverse()(found.tissue_from_tracker(p)) - p).norm() < 1e-9);
  }
}

TEST_CASE("noise leaves the residual and the error that theory expects", "[rest_calibration]") {
  std::mt19937 generator(42);
  constexpr int kPoints = 12, kTrials = 300;
  constexpr double kNoise = 0.2;  // mm per axis
  double residual = 0.0, error = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const RigidTransform truth = random_pose(generator);
    const auto tracker = cloud(kPoints, generator);
    auto tissue = moved(truth, tracker);
    for (Vec3& p : tissue) p += kNoise * normal_vector(generator);
    const Registration found = register_rigid(tracker, tissue);
    residual += found.residual_rms * found.residual_rms / kTrials;
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : tracker) middle += p / kPoints;
    error += (found.tissue_from_tracker(middle) - truth(middle)).squaredNorm() / kTrials;
    CHECK(found.tissue_from_tracker.rotation.determinant() == Approx(1.0));
  }
  // 3 N measurements less 6 unknowns; at the centroid one N-th of the noise is left.
  CHECK(residual == Approx(kNoise * kNoise * (3.0 * kPoints - 6.0) / kPoints).epsilon(0.05));
  CHECK(error == Approx(3.0 * kNoise * kNoise / kPoints).epsilon(0.2));
}

TEST_CASE("a registration is never a reflection", "[rest_calibration]") {
  std::mt19937 generator(43);
  const auto tracker = cloud(8, generator);
  std::vector<Vec3> mirrored;
  for (const Vec3& p : tracker) mirrored.push_back(Vec3(-p.x(), p.y(), p.z()));
  const Registration found = register_rigid(tracker, mirrored);
  CHECK(found.tissue_from_tracker.rotation.determinant() == Approx(1.0));
  CHECK(found.residual_rms > 1.0);
  // A flat set of markers leaves the sign of its normal to the determinant.
  std::vector<Vec3> flat = tracker;
  for (Vec3& p : flat) p.z() = 0.0;
  const RigidTransform truth = random_pose(generator);
  const Registration of_flat = register_rigid(flat, moved(truth, flat));
  CHECK(of_flat.determined);
  CHECK((of_flat.tissue_from_tracker.rotation - truth.rotation).norm() < 1e-9);
}

TEST_CASE("too few markers, or markers on a line, determine nothing", "[rest_calibration]") {
  const std::vector<Vec3> line = {{0, 0, 0}, {10, 20, 30}, {20, 40, 60}, {-5, -10, -15}};
  CHECK(!register_rigid(line, line).determined);
  CHECK(!register_rigid(std::span(line).first(2), std::span(line).first(2)).determined);
  CHECK(register_rigid({}, {}).points == 0);
}

TEST_CASE("offsets are what is left, shrunk by how well markers were placed", "[rest_calibration]") {
  std::mt19937 generator(44);
  const auto rest = cloud(5, generator);
  const RigidTransform pose = random_pose(generator);
  constexpr double kPlacement = 0.5, kNoise = 0.2;
  RestCalibration calibration(rest, kPlacement, kNoise, pose, false);
  const Vec3 offset(0.3, -0.4, 0.1);
  std::vector<Vec3> tracker = moved(pose.inverse(), rest);
  tracker[1] = pose.inverse()(rest[1] + offset);
  tracker[3].setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::vector<std::uint8_t> seen = {1, 1, 1, 0, 1};
  for (int frame = 1; frame <= 4; ++frame) {
    calibration.add(tracker, seen);
    const double shrunk = kPlacement * kPlacement / (kPlacement * kPlacement + kNoise * kNoise / frame);
    CHECK((calibration.offset(1) - shrunk * offset).norm() < 1e-9);
    CHECK((calibration.to_model(1, tracker[1]) - (rest[1] + (1.0 - shrunk) * offset)).norm() < 1e-9);
  }
  CHECK(calibration.frames() == 4);
  CHECK(!calibration.has_offset(3));
  CHECK(calibration.offset(3).norm() == 0.0);
  CHECK(calibration.registration().points == 4);
  CHECK(calibration.registration().residual_max == Approx(offset.norm()));
  calibration.reset();
  CHECK(calibration.frames() == 0);
  CHECK(!calibration.has_offset(1));
}

TEST_CASE("calibration fits the pose from the means of all frames", "[rest_calibration]") {
  std::mt19937 generator(45);
  const auto rest = cloud(9, generator);
  const RigidTransform pose = random_pose(generator);
  RestCalibration calibration(rest, 0.5, 0.2, {}, true);
  const std::vector<Vec3> still = moved(pose.inverse(), rest);
  for (int frame = 0; frame < 50; ++frame) {
    std::vector<Vec3> tracker = still;
    for (Vec3& p : tracker) p += 0.2 * normal_vector(generator);
    calibration.add(tracker, std::vector<std::uint8_t>(9, 1));
  }
  CHECK(calibration.registration().determined);
  for (int i = 0; i < 9; ++i)
    CHECK((calibration.registration().tissue_from_tracker(still[i]) - rest[i]).norm() <
          4.0 * 0.2 * std::sqrt(3.0 / 50));
}
