#include "core/particle_contact.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

const ProbeShape kShape{Vec3(0.0, 0.0, 0.0), Vec3(20.0, 8.0, 30.0), 3.0};

}  // namespace

TEST_CASE("particles leave the probe along its normal, and those that do not touch stay", "[pbd]") {
  std::mt19937 generator(41);
  const RigidTransform pose{random_rotation(generator), 30.0 * random_vector(generator)};
  NodeField x = NodeField::Zero(300, 4);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    x.row(i).head<3>() = pose(Vec3(30, 18, 40).cwiseProduct(random_vector(generator))).transpose();
  std::vector<double> mobility(300, 1.0);
  for (std::size_t i = 0; i < 300; i += 7) mobility[i] = 0.0;
  const NodeField before = x;
  ParticleContact contact(kShape, 3.0, 5.0, 0.0, 300);
  const PoseChange still{pose, pose};
  contact.find(still, mobility, x);
  contact.resolve(still, before, x);
  int pushed = 0;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const auto distance = [&](const NodeField& at) {
      return signed_distance(kShape, pose.inverse()(at.row(i).head<3>().transpose())).distance;
    };
    const double was = distance(before);
    if (was >= 3.0 || mobility[static_cast<std::size_t>(i)] == 0.0) {
      CHECK(x.row(i) == before.row(i));
      continue;
    }
    ++pushed;
    CHECK(distance(x) > 3.0 - 1e-9);
    CHECK((x.row(i) - before.row(i)).norm() == Approx(3.0 - was));
  }
  CHECK(pushed > 50);
}

TEST_CASE("a probe takes along what it presses up to the friction cone", "[pbd]") {
  // One particle under the probe's lower face, which goes down by `down` and sideways by `aside` in the substep.
  const double friction = 0.35, down = 1.0, aside = GENERATE(0.1, 0.3, 0.34, 0.5, 2.0);
  const RigidTransform begin{Mat3::Identity(), Vec3(0.0, 0.0, 33.0)};
  const PoseChange motion{begin, {Mat3::Identity(), begin.translation + Vec3(aside, 0.0, -down)}};
  NodeField x = NodeField::Zero(1, 4);
  const NodeField start = x;
  const std::vector<double> mobility{1.0};
  ParticleContact contact(kShape, 3.0, 5.0, friction, 1);
  contact.find(motion, mobility, x);
  contact.resolve(motion, start, x);
  CHECK(x(0, 2) == Approx(-down));
  CHECK(x(0, 0) == Approx(std::min(aside, friction * down)));
  CHECK(std::abs(x(0, 1)) < 1e-12);
}

TEST_CASE("a probe that turns takes along what it presses", "[pbd]") {
  const RigidTransform begin{Mat3::Identity(), Vec3(0.0, 0.0, 33.0)};
  const Mat3 turn = Eigen::AngleAxisd(0.01, Vec3::UnitZ()).toRotationMatrix();
  const PoseChange motion{begin, {turn, begin.translation - Vec3(0.0, 0.0, 1.0)}};
  NodeField x = NodeField::Zero(1, 4);
  x.row(0).head<3>() << 10.0, 0.0, 0.0;
  const NodeField start = x;
  ParticleContact contact(kShape, 3.0, 5.0, 0.35, 1);
  contact.find(motion, std::vector<double>{1.0}, x);
  contact.resolve(motion, start, x);
  CHECK((x.row(0).head<3>().transpose() - (turn * Vec3(10.0, 0.0, 0.0) - Vec3(0.0, 0.0, 1.0))).norm() < 1e-9);
}

TEST_CASE("between two poses a probe turns at constant speed", "[pbd]") {
  std::mt19937 generator(43);
  const RigidTransform from{random_rotation(generator), random_vector(generator)};
  const Mat3 quarter = Eigen::AngleAxisd(0.4, Vec3(1, 2, 2) / 3.0).toRotationMatrix();
  const RigidTransform to{from.rotation * quarter * quarter * quarter * quarter, from.translation + Vec3(4, 8, -4)};
  const RigidTransform there = interpolate(from, to, 0.25);
  CHECK((there.rotation - from.rotation * quarter).norm() < 1e-9);
  CHECK((there.translation - from.translation - Vec3(1, 2, -1)).norm() < 1e-9);
}
