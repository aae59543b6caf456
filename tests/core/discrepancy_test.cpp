// What markers say beyond the simulation: the two-stage solve against one dense regression, and pads that slip.
#include "core/discrepancy.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr double kVariance = 0.09, kSlipVariance = 0.5, kNoiseVariance = 0.01;  // mm^2

struct Body {
  Scene scene = box_scene({6, 6, 4, 10.0}, 12);
  Model model{scene, Element::smoothed, 4.0, 0.01};
  RestCompliance compliance{model};
  Discrepancy discrepancy{model, kNoiseVariance};

  void hold(std::vector<std::uint8_t> pads) {
    compliance.hold(pads);
    discrepancy.hold(compliance, pads);
  }
  // Shows `innovation` to the markers in `used`, all of them as far from known before.
  void show(const std::vector<Vec3>& innovation, const std::vector<int>& used) {
    const std::vector<double> moved(scene.markers.size(), 2.0);
    discrepancy.follow(innovation, used, moved, 0.2, 10.0, 0.01);
    discrepancy.explain(kVariance, kSlipVariance);
  }
};

// The joint covariance of all markers' and targets' axes.
Eigen::MatrixXd prior_of(const Body& body) {
  std::vector<Vec3> places;
  for (const Marker& marker : body.scene.markers) places.push_back(marker.rest);
  for (const Target& target : body.scene.targets) places.push_back(target.rest);
  const auto size = static_cast<Eigen::Index>(3 * places.size());
  const Eigen::MatrixXd slips = body.discrepancy.slip_rows().leftCols(body.discrepancy.slips());
  Eigen::MatrixXd prior = kSlipVariance * slips * slips.transpose();
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index k = i % 3; k < size; k += 3)
      prior(i, k) +=
          kVariance *
          std::exp(-(places[static_cast<std::size_t>(i / 3)] - places[static_cast<std::size_t>(k / 3)]).squaredNorm() /
                   (2.0 * Discrepancy::kLength * Discrepancy::kLength));
  return prior;
}

}  // namespace

TEST_CASE("what markers say about targets is Gaussian regression", "[discrepancy]") {
  Body body;
  body.hold(
      GENERATE(std::vector<std::uint8_t>{1, 0}, std::vector<std::uint8_t>{0, 1}, std::vector<std::uint8_t>{0, 0}));
  std::mt19937 generator(5);
  std::vector<Vec3> innovation;
  for (std::size_t i = 0; i < body.scene.markers.size(); ++i) innovation.push_back(0.3 * random_vector(generator));
  const std::vector<int> used{0, 2, 3, 5, 8, 9, 11};  // the others are too uncertain to say anything
  body.show(innovation, used);

  const Eigen::MatrixXd prior = prior_of(body);
  std::vector<Eigen::Index> rows;
  for (int marker : used)
    for (int axis = 0; axis < 3; ++axis) rows.push_back(3 * marker + axis);
  Eigen::MatrixXd seen = prior(rows, rows);
  Eigen::VectorXd b(rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const auto marker = static_cast<int>(rows[k] / 3);
    seen(row, row) += body.discrepancy.uncertainty(marker);
    b[row] = body.discrepancy.at_marker(marker)[rows[k] % 3];
  }
  const Eigen::LDLT<Eigen::MatrixXd> factor(seen);
  for (int t = 0; t < 3; ++t) {
    const auto first = 3 * static_cast<Eigen::Index>(body.scene.markers.size() + static_cast<std::size_t>(t));
    const Eigen::MatrixXd cross = prior(rows, Eigen::seqN(first, 3));
    const Vec3 mean = cross.transpose() * factor.solve(b);
    const Mat3 covariance = prior.block<3, 3>(first, first) - cross.transpose() * factor.solve(cross);
    CHECK((body.discrepancy.at_target(t) - mean).norm() < 1e-8);
    CHECK((body.discrepancy.covariance(t) - covariance).norm() < 1e-8);
  }
}

TEST_CASE("a slip along the skin is found, and moves the targets", "[discrepancy]") {
  Body body;
  body.hold({1, 0});
  const Vec3 slip(0.8, -0.5, 0.0);  // along the top
  const RowMatrix shift = body.compliance.pad_shift().topRows(3);
  const auto moved = [&](Eigen::Index place) -> Vec3 { return shift.middleCols(3 * place, 3).transpose() * slip; };
  std::vector<Vec3> innovation;
  std::vector<int> used;
  for (std::size_t i = 0; i < body.scene.markers.size(); ++i) {
    innovation.push_back(moved(static_cast<Eigen::Index>(i)));
    used.push_back(static_cast<int>(i));
  }
  for (int frame = 0; frame < 20; ++frame) body.show(innovation, used);
  CHECK((body.discrepancy.slip(0) - slip).norm() < 0.1 * slip.norm());
  CHECK(body.discrepancy.slip(1) == Vec3::Zero());
  for (int t = 0; t < 3; ++t) {
    const Vec3 truth = moved(static_cast<Eigen::Index>(body.scene.markers.size()) + t);
    CHECK((body.discrepancy.at_target(t) - truth).norm() < 0.2 * truth.norm());
  }
  // A push is not a slip: across the skin the pad is where it is said to be.
  const Mat3 across = body.compliance.pad_shift().block<3, 3>(0, 0);
  CHECK(across.norm() > 0.0);
  CHECK(body.discrepancy.slip_rows().col(2).norm() < 1e-9 * body.discrepancy.slip_rows().norm());
}

TEST_CASE("pads that share nodes hold together", "[discrepancy]") {
  Body body;
  REQUIRE_FALSE(shared_nodes(body.scene.mesh, "A1", "A2").empty());
  body.hold({1, 1});
  CHECK(body.discrepancy.slip_rows().allFinite());
  // Moved together they move what is between them with them, and nothing further.
  const RowMatrix both = body.compliance.pad_shift().topRows(3) + body.compliance.pad_shift().bottomRows(3);
  CHECK(both.cwiseAbs().maxCoeff() < 1.5);
}
