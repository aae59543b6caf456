#include "core/particle_readout.hpp"

#include <catch2/catch.hpp>

#include "core/scene_places.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

struct Body {
  ParticleLattice lattice{box_scene({4, 3, 2, 10.0}).mesh, 5.0};
  NodeField rest = NodeField::Zero(lattice.count(), 4);
  Body() {
    for (int i = 0; i < lattice.count(); ++i) rest.row(i).head<3>() = lattice.rest(i).transpose();
  }
  template <typename Motion>
  NodeField moved(const Motion& motion) const {
    NodeField x = rest;
    for (int i = 0; i < lattice.count(); ++i) x.row(i).head<3>() = motion(lattice.rest(i)).transpose();
    return x;
  }
};

}  // namespace

TEST_CASE("blend returns affine motions exactly, inside, at corners and off the skin", "[pbd]") {
  const Body body;
  const std::vector<ParticleReadout::Point> points{
      {{20, 15, 10}, {20, 15, 10}}, {{0, 0, 0}, {0, 0, 0}}, {{40, 30, 20}, {40, 30, 20}}, {{7, 20, 28}, {7, 20, 20}}};
  const ParticleReadout readout(body.lattice, PbdReadout::blend, points);
  std::mt19937 generator(23);
  const Mat3 a = random_matrix(generator);
  const Vec3 shift = random_vector(generator);
  const NodeField x = body.moved([&](const Vec3& p) { return Vec3(a * p + shift); });
  for (int k = 0; k < readout.count(); ++k) {
    const Vec3& p = points[static_cast<std::size_t>(k)].position;
    CHECK((readout.displacement(k, body.rest, x) - (a * p + shift - p)).norm() < 1e-9);
  }
}

TEST_CASE("blend is smooth from point to point where nearest jumps", "[pbd]") {
  const Body body;
  std::vector<ParticleReadout::Point> points;
  for (int k = 0; k <= 400; ++k) points.push_back({{5.0 + 0.075 * k, 14.0, 11.0}, {5.0 + 0.075 * k, 14.0, 11.0}});
  const NodeField x = body.moved([](const Vec3& p) { return Vec3(p.x(), p.y() + 3.0 * std::sin(0.2 * p.x()), p.z()); });
  const auto largest_step = [&](PbdReadout kind) {
    const ParticleReadout readout(body.lattice, kind, points);
    double largest = 0.0;
    for (int k = 1; k < readout.count(); ++k)
      largest =
          std::max(largest, (readout.displacement(k, body.rest, x) - readout.displacement(k - 1, body.rest, x)).norm());
    return largest;
  };
  // The motion itself changes by at most 0.6 mm a mm: 0.045 in a step of 0.075 mm.
  CHECK(largest_step(PbdReadout::blend) < 0.07);
  CHECK(largest_step(PbdReadout::nearest) > 1.0);
}

TEST_CASE("nearest is the particle that is nearest at rest", "[pbd]") {
  const Body body;
  std::mt19937 generator(29);
  std::vector<ParticleReadout::Point> points;
  for (int k = 0; k < 20; ++k) {
    const Vec3 p = Vec3(20, 15, 10) + Vec3(15, 10, 8).cwiseProduct(random_vector(generator));
    points.push_back({p, p});
  }
  const ParticleReadout readout(body.lattice, PbdReadout::nearest, points);
  NodeField x = body.rest;
  for (int i = 0; i < body.lattice.count(); ++i) x.row(i).head<3>() += random_vector(generator).transpose();
  for (int k = 0; k < 20; ++k) {
    Eigen::Index best = 0;
    const Eigen::RowVector3d p = points[static_cast<std::size_t>(k)].position.transpose();
    (body.rest.leftCols<3>().rowwise() - p).rowwise().squaredNorm().minCoeff(&best);
    CHECK(readout.displacement(k, body.rest, x) == Vec3((x - body.rest).row(best).head<3>().transpose()));
  }
}

TEST_CASE("a marker on a stalk is read from the skin below it, and turns with it", "[pbd]") {
  Scene scene = box_scene({4, 3, 2, 10.0}, 0);
  scene.markers = {{"high", Vec3(33.0, 27.0, 27.0)}, {"low", Vec3(33.0, 27.0, 20.3)}};
  std::vector<ParticleReadout::Point> points;
  for (const MaterialPoint& place : points_of_markers(scene))
    points.push_back(ParticleReadout::point_at(scene.mesh, place));
  CHECK((points[0].position - Vec3(33.0, 27.0, 27.0)).norm() < 1e-9);
  CHECK((points[0].foot - Vec3(33.0, 27.0, 20.0)).norm() < 1e-9);
  CHECK((points[1].position - Vec3(33.0, 27.0, 20.0)).norm() < 1e-9);
  const Body body;
  const ParticleReadout readout(body.lattice, PbdReadout::blend, points);
  std::mt19937 generator(31);
  const Mat3 turn = random_rotation(generator);
  const NodeField x = body.moved([&](const Vec3& p) { return Vec3(turn * p); });
  CHECK((readout.displacement(0, body.rest, x) - (turn * points[0].position - points[0].position)).norm() < 1e-9);
}
