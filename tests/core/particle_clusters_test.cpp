#include "core/particle_clusters.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <catch2/catch.hpp>
#include <set>

#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

NodeField rest_of(const ParticleLattice& lattice) {
  NodeField x = NodeField::Zero(lattice.count(), 4);
  for (int i = 0; i < lattice.count(); ++i) x.row(i).head<3>() = lattice.rest(i).transpose();
  return x;
}

Vec3 place(const NodeField& x, int i) { return x.row(i).head<3>().transpose(); }

// Equations (4) and (5) particle by particle, with Eigen's decomposition: what match_shapes has to do.
NodeField matched(const ParticleLattice& lattice, const ParticleClusters& clusters, double alpha, const NodeField& x) {
  NodeField moved = x;
  std::vector<Vec3> sum(static_cast<std::size_t>(lattice.count()), Vec3::Zero());
  std::vector<int> times(sum.size(), 0);
  for (int c = 0; c < clusters.count(); ++c) {
    const auto weight = [&](int k) { return clusters.share[static_cast<std::size_t>(clusters.particle[k])]; };
    Vec3 now = Vec3::Zero(), rest = Vec3::Zero();
    double total = 0.0;
    for (int k = clusters.first[c]; k < clusters.first[c + 1]; ++k) {
      now += weight(k) * place(x, clusters.particle[k]);
      rest += weight(k) * lattice.rest(clusters.particle[k]);
      total += weight(k);
    }
    now /= total;
    rest /= total;
    Mat3 a = Mat3::Zero();
    for (int k = clusters.first[c]; k < clusters.first[c + 1]; ++k)
      a += weight(k) * (place(x, clusters.particle[k]) - now) * (lattice.rest(clusters.particle[k]) - rest).transpose();
    const Eigen::JacobiSVD<Mat3> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Mat3 sign = Mat3::Identity();
    sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
    const Mat3 turn = svd.matrixU() * sign * svd.matrixV().transpose();
    for (int k = clusters.first[c]; k < clusters.first[c + 1]; ++k) {
      const int i = clusters.particle[k];
      sum[static_cast<std::size_t>(i)] += turn * (lattice.rest(i) - rest) + now;
      ++times[static_cast<std::size_t>(i)];
    }
  }
  for (int i = 0; i < lattice.count(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    moved.row(i).head<3>() += alpha * (sum[at] / times[at] - place(x, i)).transpose();
  }
  return moved;
}

}  // namespace

TEST_CASE("every particle is in a cluster, and clusters lie as spacing and radius say", "[pbd]") {
  const ParticleLattice lattice(box_scene({6, 5, 4, 10.0}).mesh, 5.0);
  struct Row {
    double spacing, radius;
  };
  const Row row = GENERATE(Row{11.1626, 8.5424}, Row{9.6001, 9.1674}, Row{20.0, 10.0}, Row{5.0, 2.5}, Row{35.0, 17.5});
  CAPTURE(row.spacing, row.radius);
  const ParticleClusters clusters(lattice, row.spacing, row.radius);
  std::vector<int> times(static_cast<std::size_t>(lattice.count()), 0);
  for (int c = 0; c < clusters.count(); ++c) {
    REQUIRE(clusters.members(c) > 0);
    std::set<int> members;
    Vec3 arms = Vec3::Zero();
    double weights = 0.0;
    for (int k = clusters.first[c]; k < clusters.first[c + 1]; ++k) {
      members.insert(clusters.particle[k]);
      arms += clusters.arm[k][3] * clusters.arm[k].head<3>();
      weights += clusters.arm[k][3];
      ++times[static_cast<std::size_t>(clusters.particle[k])];
    }
    CHECK(static_cast<int>(members.size()) == clusters.members(c));
    CHECK(arms.norm() < 1e-9);
    CHECK(weights == Approx(1.0));
  }
  for (int i = 0; i < lattice.count(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    CHECK(times[at] > 0);
    CHECK(clusters.share[at] == Approx(1.0 / times[at]));
  }
  // Balls of a spacing around the seeds cover the body.
  const double volume = lattice.count() * std::pow(lattice.spacing(), 3);
  CHECK(clusters.count() * 4.0 / 3.0 * 3.14159 * std::pow(row.spacing, 3) > volume);
}

TEST_CASE("a cluster inside of the body holds the particles within its radius", "[pbd]") {
  const ParticleLattice lattice(box_scene({6, 6, 6, 10.0}).mesh, 5.0);
  const double radius = 9.0;
  const ParticleClusters clusters(lattice, 10.0, radius);
  int inner = 0;
  for (int c = 0; c < clusters.count(); ++c) {
    Vec3 center = Vec3::Zero();
    for (int k = clusters.first[c]; k < clusters.first[c + 1]; ++k)
      center += lattice.rest(clusters.particle[k]) / clusters.members(c);
    if ((center.array() < 15.0).any() || (center.array() > 45.0).any()) continue;
    ++inner;
    CHECK(clusters.members(c) * 125.0 == Approx(4.0 / 3.0 * 3.14159 * std::pow(radius, 3)).epsilon(0.35));
  }
  CHECK(inner > 5);
}

TEST_CASE("a rigid motion is a shape that matches", "[pbd]") {
  const ParticleLattice lattice(box_scene({4, 3, 2, 10.0}).mesh, 5.0);
  const ParticleClusters clusters(lattice, 11.1626, 8.5424);
  ClusterState state(clusters);
  const std::vector<double> free(static_cast<std::size_t>(lattice.count()), 1.0);
  std::mt19937 generator(17);
  const Mat3 turn = random_rotation(generator);
  const Vec3 shift = 50.0 * random_vector(generator);
  NodeField x = rest_of(lattice);
  for (int i = 0; i < lattice.count(); ++i) x.row(i).head<3>() = (turn * lattice.rest(i) + shift).transpose();
  const NodeField before = x;
  match_shapes(clusters, 1.0, free, x, state);
  CHECK((x - before).cwiseAbs().maxCoeff() < 1e-6);
}

TEST_CASE("shape matching is equations 4 and 5, solved by singular values", "[pbd]") {
  const ParticleLattice lattice(box_scene({4, 3, 2, 10.0}).mesh, 5.0);
  const ParticleClusters clusters(lattice, 11.1626, 8.5424);
  ClusterState state(clusters);
  std::vector<double> mobility(static_cast<std::size_t>(lattice.count()), 1.0);
  mobility[5] = 0.0;
  std::mt19937 generator(19);
  NodeField x = rest_of(lattice);
  for (int i = 0; i < lattice.count(); ++i) x.row(i).head<3>() += 2.0 * random_vector(generator).transpose();
  for (int iteration = 0; iteration < 5; ++iteration) {
    NodeField twin = matched(lattice, clusters, 0.46489, x);
    twin.row(5) = x.row(5);
    REQUIRE((twin - x).rowwise().norm().maxCoeff() > 0.01);
    match_shapes(clusters, 0.46489, mobility, x, state);
    CHECK((x - twin).cwiseAbs().maxCoeff() < 1e-6);
  }
}

TEST_CASE("shape matching conserves momentum, linear and angular", "[pbd]") {
  const ParticleLattice lattice(box_scene({6, 5, 4, 10.0}).mesh, 5.0);
  const ParticleClusters clusters(lattice, 11.1626, 8.5424);
  ClusterState state(clusters);
  const std::vector<double> free(static_cast<std::size_t>(lattice.count()), 1.0);
  std::mt19937 generator(47);
  NodeField x = rest_of(lattice);
  for (int i = 0; i < lattice.count(); ++i) x.row(i).head<3>() += random_vector(generator).transpose();
  const NodeField before = x;
  match_shapes(clusters, 0.46489, free, x, state);
  REQUIRE((x - before).rowwise().norm().maxCoeff() > 0.1);
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  for (int i = 0; i < lattice.count(); ++i) {
    const Vec3 move = place(x, i) - place(before, i);
    linear += move;
    angular += place(before, i).cross(move);
  }
  CHECK(linear.norm() < 1e-9);
  CHECK(angular.norm() < 1e-4);
}
