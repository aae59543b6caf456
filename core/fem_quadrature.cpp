#include "core/fem_quadrature.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/types.hpp"

namespace tissued::core {

namespace {

// All distinct places of a point (a, a, a, 1 - 3a).
void add_vertex_orbit(TetQuadrature& rule, double a, double weight) {
  for (std::size_t i = 0; i < 4; ++i) {
    std::array<double, 4> point{a, a, a, a};
    point[i] = 1.0 - 3.0 * a;
    rule.points.push_back(point);
    rule.weights.push_back(weight);
  }
}

// (a, a, b, b), 2a + 2b = 1.
void add_edge_orbit(TetQuadrature& rule, double a, double weight) {
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      std::array<double, 4> point;
      point.fill(0.5 - a);
      point[i] = point[j] = a;
      rule.points.push_back(point);
      rule.weights.push_back(weight);
    }
  }
}

// (a, a, b, 1 - 2a - b), b and the rest different.
void add_face_orbit(TetQuadrature& rule, double a, double b, double weight) {
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      if (i == j) continue;
      std::array<double, 4> point;
      point.fill(a);
      point[i] = b;
      point[j] = 1.0 - 2.0 * a - b;
      rule.points.push_back(point);
      rule.weights.push_back(weight);
    }
  }
}

struct LineRule {
  Eigen::VectorXd points, weights;  // on [0, 1]; weights sum to 1 / (power + 1)
};

// Gauss-Jacobi for the weight (1 - t)^power on [0, 1], by the eigenvalues of its three-term recurrence (Golub, Welsch).
LineRule gauss_jacobi(int count, int power) {
  const double a = power;
  Eigen::MatrixXd recurrence = Eigen::MatrixXd::Zero(count, count);
  for (int k = 0; k < count; ++k) {
    const double s = 2.0 * k + a;
    recurrence(k, k) = k == 0 ? -a / (a + 2.0) : -a * a / (s * (s + 2.0));
    if (k == 0) continue;
    const double square = 4.0 * k * k * (k + a) * (k + a) / (s * s * (s * s - 1.0));
    recurrence(k, k - 1) = recurrence(k - 1, k) = std::sqrt(square);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(recurrence);
  return {0.5 * (eigen.eigenvalues().array() + 1.0), eigen.eigenvectors().row(0).array().square() / (power + 1.0)};
}

// Duffy: the cube collapsed onto the tetrahedron.
TetQuadrature collapsed_product(int degree) {
  const int n = degree / 2 + 1;
  const LineRule u = gauss_jacobi(n, 2), v = gauss_jacobi(n, 1), w = gauss_jacobi(n, 0);
  TetQuadrature rule;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        const double x = u.points[i], y = v.points[j] * (1.0 - x), z = w.points[k] * (1.0 - x - y);
        rule.points.push_back({x, y, z, 1.0 - x - y - z});
        rule.weights.push_back(6.0 * u.weights[i] * v.weights[j] * w.weights[k]);
      }
    }
  }
  return rule;
}

}  // namespace

TetQuadrature tet_quadrature(int degree) {
  TetQuadrature rule;
  if (degree < 1 || degree > 9)
    throw ModelError("a quadrature of degree " + std::to_string(degree) + " is not known: 1 to 9");
  if (degree == 1) {
    rule.points.push_back({0.25, 0.25, 0.25, 0.25});
    rule.weights.push_back(1.0);
  } else if (degree == 2) {
    add_vertex_orbit(rule, 0.13819660112501051518, 0.25);
  } else if (degree == 3) {  // Zienkiewicz, Taylor; the weight in the middle is negative
    rule.points.push_back({0.25, 0.25, 0.25, 0.25});
    rule.weights.push_back(-0.8);
    add_vertex_orbit(rule, 1.0 / 6.0, 0.45);
  } else if (degree <= 5) {  // Walkington 2000
    add_vertex_orbit(rule, 0.31088591926330060980, 0.11268792571801585080);
    add_vertex_orbit(rule, 0.09273525031089122640, 0.07349304311636194954);
    add_edge_orbit(rule, 0.04550370412564964949, 0.04254602077708146644);
  } else if (degree == 6) {  // Keast 1986
    add_vertex_orbit(rule, 0.21460287125915202929, 0.03992275025816749210);
    add_vertex_orbit(rule, 0.04067395853461135311, 0.01007721105532064295);
    add_vertex_orbit(rule, 0.32233789014227551034, 0.05535718154365472210);
    add_face_orbit(rule, 0.06366100187501752530, 0.26967233145831580803, 0.04821428571428571429);
  } else {
    rule = collapsed_product(degree);
  }
  return rule;
}

}  // namespace tissued::core
