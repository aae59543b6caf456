// Quadrature and shape functions against integrals in closed form.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/fem_mesh.hpp"
#include "core/fem_quadrature.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

double factorial(int n) { return std::tgamma(n + 1.0); }

// Of x^a y^b z^c over the reference tetrahedron, as a share of its volume.
double monomial(int a, int b, int c) {
  return 6.0 * factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3);
}

}  // namespace

TEST_CASE("a quadrature integrates what its degree promises, and not all of the next", "[fem]") {
  for (int degree = 1; degree <= 9; ++degree) {
    const TetQuadrature rule = tet_quadrature(degree);
    const auto error = [&](int order) {
      double worst = 0.0;
      for (int a = 0; a <= order; ++a) {
        for (int b = 0; a + b <= order; ++b) {
          const int c = order - a - b;
          double sum = 0.0;
          for (int q = 0; q < rule.count(); ++q)
            sum += rule.weights[q] * std::pow(rule.points[q][1], a) * std::pow(rule.points[q][2], b) *
                   std::pow(rule.points[q][3], c);
          worst = std::max(worst, std::abs(sum - monomial(a, b, c)));
        }
      }
      return worst;
    };
    INFO("degree " << degree);
    for (int order = 0; order <= degree; ++order) CHECK(error(order) < 1e-14);
    if (degree == 1 || degree == 2 || degree == 3 || degree == 5 || degree == 6) CHECK(error(degree + 1) > 1e-6);
  }
}

TEST_CASE("a quadrature that is not known is refused", "[fem]") {
  CHECK_THROWS_AS(tet_quadrature(0), ModelError);
  CHECK_THROWS_AS(tet_quadrature(10), ModelError);
}

TEST_CASE("shape functions interpolate, and their slopes and integrals are theirs", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const int nodes = nodes_per_element(element);
  std::mt19937 generator(3);
  const auto barycentric = [&] {
    const Vec3 v = 0.3 * random_vector(generator);
    return std::array<double, 4>{v[0], v[1], v[2], 1.0 - v.sum()};
  };
  for (int a = 0; a < nodes; ++a) {
    std::array<double, 4> node{};
    if (a < 4) {
      node[a] = 1.0;
    } else {
      node[kTetEdges[a - 4][0]] = node[kTetEdges[a - 4][1]] = 0.5;
    }
    const ShapeValues values = shape_values(element, node);
    for (int b = 0; b < nodes; ++b) CHECK(values[b] == Approx(a == b ? 1.0 : 0.0).margin(1e-15));
  }
  constexpr double kStep = 1e-6;
  const std::array<double, 4> place = barycentric();
  const ShapeSlopes slopes = shape_slopes(element, place);
  for (int k = 0; k < 4; ++k) {
    std::array<double, 4> plus = place, minus = place;
    plus[k] += kStep;
    minus[k] -= kStep;
    const ShapeValues up = shape_values(element, plus), down = shape_values(element, minus);
    for (int a = 0; a < nodes; ++a) CHECK(slopes[a][k] == Approx((up[a] - down[a]) / (2.0 * kStep)).margin(1e-9));
  }
  const TetQuadrature rule = tet_quadrature(5);
  const ShapeValues integrals = shape_integrals(element);
  for (int a = 0; a < nodes; ++a) {
    double sum = 0.0;
    for (int q = 0; q < rule.count(); ++q) sum += rule.weights[q] * shape_values(element, rule.points[q])[a];
    CHECK(integrals[a] == Approx(sum).margin(1e-14));
  }
}

TEST_CASE("a quadratic body shares the nodes of its edges and reads a quadratic field exactly", "[fem]") {
  const Scene scene = box_scene({3, 2, 2, 10.0});
  const FemMesh mesh = make_fem_mesh(scene.mesh, FemElement::p2);
  // Euler: for a ball cut into tetrahedra, nodes - edges + facets - tets = 1, and 4 tets = 2 facets - boundary.
  const int boundary = static_cast<int>(boundary_of(scene.mesh).size());
  const int facets = (4 * scene.mesh.tet_count() + boundary) / 2;
  CHECK(static_cast<int>(mesh.edges.size()) == scene.mesh.node_count() + facets - scene.mesh.tet_count() - 1);
  const auto field = [](const Vec3& p) {
    return Vec3(p.x() * p.y(), p.z() * p.z() - p.x(), 2.0 * p.y() * p.z() + p.squaredNorm());
  };
  Eigen::VectorXd x(3 * mesh.node_count());
  for (int i = 0; i < mesh.node_count(); ++i) x.segment<3>(3 * i) = field(mesh.rest.row(i).transpose());
  for (const Target& target : scene.targets) {
    const Vec3 read = position_of(fem_point(mesh, locate_in_volume(scene.mesh, target.rest)), x);
    CHECK((read - field(target.rest)).norm() < 1e-9);
  }
  for (const Marker& marker : scene.markers) {
    const MaterialPoint point = locate_on_surface(scene.mesh, boundary_of(scene.mesh), marker.rest);
    const Vec3 read = position_of(fem_point(mesh, point), x);
    CHECK((read - field(rest_position(scene.mesh, point))).norm() < 1e-9);
  }
}

TEST_CASE("a pad's force is shared out evenly over its facets", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const Scene scene = box_scene({4, 3, 2, 10.0});
  const FemMesh mesh = make_fem_mesh(scene.mesh, element);
  const SurfaceGroup& group = *scene.mesh.find_surface("A1");
  const std::vector<int> nodes = nodes_of(mesh, group);
  const std::vector<double> shares = shares_of(mesh, group);
  REQUIRE(nodes.size() == shares.size());
  double total = 0.0;
  Vec3 middle = Vec3::Zero(), expected = Vec3::Zero();
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    total += shares[k];
    middle += shares[k] * mesh.rest.row(nodes[k]).transpose();
  }
  // All facets of the box are of one area: the middle of the force is the mean of their middles.
  for (const Triangle& t : group.triangles)
    for (int node : t) expected += scene.mesh.node(node) / (3.0 * static_cast<double>(group.triangles.size()));
  CHECK(total == Approx(1.0));
  CHECK((middle - expected).norm() < 1e-12);
}
