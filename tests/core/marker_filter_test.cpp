// The modal marker filter against the dense textbook filter, frame by frame.
#include <catch2/catch.hpp>

#include "core/admm_simulator.hpp"
#include "core/marker_filter.hpp"
#include "tests/core/test_bodies.hpp"
#include "tests/core/textbook_filter.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr double kWeightScale = 4.0, kTimeStep = 0.01;

struct Bench {
  Model model;
  ModalBasis basis;
  MarkerFilter filter;

  Bench(const Scene& scene, const FilterOptions& options)
      : model(scene, Element::p1, kWeightScale, kTimeStep),
        basis(modal_basis(model.laplacian(), model.masses(), model.system().free_nodes(), options.modes)),
        filter(model, basis, options) {}

  // The filter's own covariance in nodal coordinates.
  Eigen::MatrixXd nodal_covariance() const {
    const auto& phi = filter.basis().shapes;
    const ModalCovariance& p = filter.covariance();
    Eigen::MatrixXd out(2 * phi.rows(), 2 * phi.rows());
    const Eigen::MatrixXd cross = phi * p.cross() * phi.transpose();
    out << phi * p.now() * phi.transpose(), cross, cross.transpose(), phi * p.before() * phi.transpose();
    return out;
  }
};

TextbookFilter textbook_of(const Model& model, const FilterOptions& options) {
  const bool paper = options.preset == NoisePreset::paper;
  constexpr double kPadVariance = 1e-6;
  return {model, options.preset, paper ? 3.0 : 1.0, paper ? 0.01 : 0.1 * 0.1, kPadVariance};
}

struct Frame {
  std::vector<Vec3> markers;
  NodeField x, x_previous;
};

Frame random_frame(const Model& model, std::mt19937& generator) {
  Frame frame{{}, model.rest(), model.rest()};
  for (const Marker& marker : model.scene().markers)
    frame.markers.push_back(marker.rest + 4.0 * random_vector(generator));
  for (int node : model.system().free_nodes()) {
    frame.x.row(node).head<3>() += 3.0 * random_vector(generator).transpose();
    frame.x_previous.row(node).head<3>() += 3.0 * random_vector(generator).transpose();
  }
  return frame;
}

// K (y - C x) of both blocks, (2 free x 3); innovations of pads are nothing: predict holds them exactly.
Eigen::MatrixXd textbook_correction(const Model& model, const TextbookFilter& textbook, const Frame& frame,
                                    const std::vector<std::uint8_t>& seen) {
  Eigen::MatrixXd innovation = Eigen::MatrixXd::Zero(textbook.gain().cols(), 3);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) continue;
    Vec3 moved = Vec3::Zero();
    const MaterialPoint& point = model.marker_points()[i];
    for (int a = 0; a < point.count; ++a)
      moved +=
          point.weights[a] * (frame.x.row(point.nodes[a]) - model.rest().row(point.nodes[a])).head<3>().transpose();
    innovation.row(row++) = (frame.markers[i] - model.scene().markers[i].rest - moved).transpose();
  }
  return textbook.gain() * innovation;
}

Eigen::MatrixXd correction_of(const Model& model, const Frame& before, const Frame& after) {
  const std::vector<int>& free = model.system().free_nodes();
  const auto count = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd out(2 * count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    out.row(i) = (after.x - before.x).row(free[static_cast<std::size_t>(i)]).head<3>();
    out.row(count + i) = (after.x_previous - before.x_previous).row(free[static_cast<std::size_t>(i)]).head<3>();
  }
  return out;
}

std::vector<std::uint8_t> random_flags(std::size_t count, std::mt19937& generator) {
  std::vector<std::uint8_t> flags(count);
  for (std::uint8_t& flag : flags) flag = generator() % 2;
  return flags;
}

}  // namespace

TEST_CASE("the marker filter is the textbook filter, whatever is seen and held", "[marker_filter]") {
  const NoisePreset preset = GENERATE(NoisePreset::force, NoisePreset::paper);
  FilterOptions options;
  options.preset = preset;
  Bench bench(box_scene({3, 3, 2, 10.0}), options);
  TextbookFilter textbook = textbook_of(bench.model, options);
  bench.filter.reset();
  textbook.covariance = bench.nodal_covariance();
  std::mt19937 generator(21);
  const std::size_t markers = bench.model.scene().markers.size();
  std::vector<std::uint8_t> pads(2, 0);
  for (int k = 0; k < 30; ++k) {
    auto seen = random_flags(markers, generator);
    if (k % 7 == 0) seen.assign(markers, 0);
    if (k % 7 == 3) seen.assign(markers, 1);
    if (k % 4 == 0) pads = random_flags(2, generator);
    const int frames = k % 5 == 4 ? 3 : 1;
    const Frame before = random_frame(bench.model, generator);
    Frame after = before;
    const Innovation innovation = bench.filter.correct(after.markers, seen, pads, frames, after.x, after.x_previous);
    textbook.step(seen, pads, frames);
    REQUIRE(!bench.filter.settled());
    const Eigen::MatrixXd expected = textbook_correction(bench.model, textbook, before, seen);
    INFO("frame " << k << ", preset " << static_cast<int>(preset));
    CHECK((correction_of(bench.model, before, after) - expected).cwiseAbs().maxCoeff() < 1e-9);
    CHECK(innovation.markers_used == std::count(seen.begin(), seen.end(), std::uint8_t{1}));
    for (int t = 0; t < 3; ++t)
      CHECK(std::abs(bench.filter.target_variance(t) - textbook.target_variance(t)) <
            1e-9 * (1.0 + textbook.target_variance(t)));
  }
}

TEST_CASE("the filter starts where the textbook settles with all markers seen", "[marker_filter]") {
  FilterOptions options;
  options.preset = GENERATE(NoisePreset::force, NoisePreset::paper);
  Bench bench(box_scene({2, 2, 2, 10.0}), options);
  TextbookFilter textbook = textbook_of(bench.model, options);
  textbook.settle(std::vector<std::uint8_t>(bench.model.scene().markers.size(), 1), {0, 0}, 1000);
  const Eigen::MatrixXd covariance = bench.nodal_covariance();
  CHECK((covariance - textbook.covariance).cwiseAbs().maxCoeff() < 1e-4 * textbook.covariance.cwiseAbs().maxCoeff());
}

TEST_CASE("the force preset gives the markers the prior variance it is asked for", "[marker_filter]") {
  const Model model(box_scene({2, 2, 2, 10.0}), Element::p1, kWeightScale, kTimeStep);
  CHECK(textbook_of(model, FilterOptions{}).marker_prior() == Approx(1.0));
}

TEST_CASE("a settled gain equals the one that is computed anew", "[marker_filter]") {
  Bench bench(box_scene({3, 2, 2, 10.0}), FilterOptions{});
  TextbookFilter textbook = textbook_of(bench.model, FilterOptions{});
  bench.filter.reset();
  textbook.covariance = bench.nodal_covariance();
  std::mt19937 generator(22);
  std::vector<std::uint8_t> seen(bench.model.scene().markers.size(), 1);
  const std::vector<std::uint8_t> pads{1, 0};
  seen[2] = 0;
  int settled_frames = 0;
  for (int k = 0; k < 1500 && settled_frames < 20; ++k) {
    const Frame before = random_frame(bench.model, generator);
    Frame after = before;
    bench.filter.correct(after.markers, seen, pads, 1, after.x, after.x_previous);
    textbook.step(seen, pads, 1);
    if (!bench.filter.settled()) continue;
    ++settled_frames;
    const Eigen::MatrixXd expected = textbook_correction(bench.model, textbook, before, seen);
    CHECK((correction_of(bench.model, before, after) - expected).cwiseAbs().maxCoeff() < 1e-4);
    CHECK(bench.filter.target_variance(1) == Approx(textbook.target_variance(1)).epsilon(1e-4));
  }
  CHECK(settled_frames == 20);
}

TEST_CASE("after a reset nothing of the last frame's markers is left", "[marker_filter]") {
  Bench bench(box_scene({2, 2, 2, 10.0}), FilterOptions{});
  bench.filter.reset();
  std::mt19937 generator(23);
  const Frame before = random_frame(bench.model, generator);
  Frame after = before;
  for (Vec3& marker : after.markers) marker.setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::vector<std::uint8_t> none(bench.model.scene().markers.size(), 0), off(2, 0);
  const Innovation innovation = bench.filter.correct(after.markers, none, off, 1, after.x, after.x_previous);
  CHECK(innovation.markers_used == 0);
  CHECK(after.x == before.x);
  CHECK(after.x_previous == before.x_previous);
}

TEST_CASE("without markers and pads the variance of a target grows to its prior", "[marker_filter]") {
  Bench bench(box_scene({2, 2, 2, 10.0}), FilterOptions{});
  bench.filter.reset();
  Frame frame{std::vector<Vec3>(7, Vec3::Zero()), bench.model.rest(), bench.model.rest()};
  const std::vector<std::uint8_t> none(7, 0), off(2, 0);
  double last = bench.filter.target_variance(0);
  for (int k = 0; k < 5; ++k) {
    bench.filter.correct(frame.markers, none, off, 1, frame.x, frame.x_previous);
    CHECK(bench.filter.target_variance(0) > last);
    last = bench.filter.target_variance(0);
  }
  CHECK(!bench.filter.settled());
}

TEST_CASE("a few modes stay finite and claim less than all of them", "[marker_filter]") {
  const Scene scene = box_scene({3, 3, 2, 10.0});
  FilterOptions few;
  few.modes = 20;
  Bench bench(scene, few);
  REQUIRE(bench.filter.basis().modes() == 20);
  CHECK(!bench.filter.basis().complete);
  std::mt19937 generator(24);
  for (int k = 0; k < 60; ++k) {
    Frame frame = random_frame(bench.model, generator);
    bench.filter.correct(frame.markers, random_flags(7, generator), random_flags(2, generator), 1, frame.x,
                         frame.x_previous);
    REQUIRE(frame.x.allFinite());
    REQUIRE(frame.x_previous.allFinite());
    for (int t = 0; t < 3; ++t) REQUIRE(bench.filter.target_variance(t) >= 0.0);
  }
  // The lowest modes are those of the complete basis.
  const ModalBasis all =
      modal_basis(bench.model.laplacian(), bench.model.masses(), bench.model.system().free_nodes(), 0);
  for (int j = 0; j < 20; ++j) CHECK(bench.filter.basis().lambda[j] == Approx(all.lambda[j]).epsilon(1e-6));
}
