// Sensitivities, direct and adjoint, against central differences of whole solves.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <functional>

#include "core/fem_sensitivity.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

// A body pushed by one pad, and everything that is seen of it.
class Pushed {
 public:
  explicit Pushed(FemElement element)
      : scene_(make_scene()), model_(scene_, options(element)), equilibrium_(model_, 1) {
    pads_.resize(2);
    pads_[0].kind = PadInput::Kind::pose;
    pads_[0].center = scene_.pads[0].center + Vec3(0.5, -0.3, -2.5);
    pads_[0].rotation = Eigen::AngleAxisd(0.1, Vec3::UnitY()).toRotationMatrix();
    control_.tolerance = 1e-10;
    state_ = solve();
  }

  FemState solve() {
    FemState state = rest_state(model_);
    REQUIRE(solve_static(equilibrium_, state, {pads_}, control_).converged);
    return state;
  }

  // Two coordinates of a marker and of a target, the pad's force.
  std::vector<double> observe(const FemState& state) const {
    const Vec3 marker = position_of(model_.marker_points()[1], state.x);
    const Vec3 target = position_of(model_.target_points()[2], state.x), force = pad_forces(state, pads_)[0];
    return {marker.x(), marker.z(), target.x(), target.z(), force.x(), force.y(), force.z()};
  }

  static std::vector<FemObservable> observables(const FemSensitivity& s) {
    const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
    return {s.of_marker(1, x),    s.of_marker(1, z),    s.of_target(2, x),   s.of_target(2, z),
            s.of_pad_force(0, x), s.of_pad_force(0, y), s.of_pad_force(0, z)};
  }

  // set(h) disturbs the problem by h; set(0) restores it.
  void check(const std::string& what, const FemPerturbation& perturbation, double step,
             const std::function<void(double)>& set) {
    set(step);
    const std::vector<double> plus = observe(solve());
    set(-step);
    const std::vector<double> minus = observe(solve());
    set(0.0);
    FemSensitivity sensitivity(equilibrium_, state_);
    const FemResponse response = sensitivity.response(perturbation);
    const std::vector<FemObservable> all = observables(sensitivity);
    double largest = 0.0;
    for (std::size_t k = 0; k < all.size(); ++k) largest = std::max(largest, std::abs(plus[k] - minus[k]) / (2 * step));
    REQUIRE(largest > 0.0);
    for (std::size_t k = 0; k < all.size(); ++k) {
      INFO(what << ", observable " << k);
      const double difference = (plus[k] - minus[k]) / (2.0 * step);
      CHECK(derivative(all[k], response) == Approx(difference).epsilon(1e-5).margin(1e-5 * largest));
      CHECK(derivative(sensitivity.adjoint(all[k]), perturbation) ==
            Approx(derivative(all[k], response)).epsilon(1e-9).margin(1e-11 * largest));
    }
  }

  Scene scene_;
  FemModel model_;
  FemEquilibrium equilibrium_;
  std::vector<PadInput> pads_;
  FemControl control_;
  FemState state_;

 private:
  static Scene make_scene() {
    Scene scene = box_scene({3, 2, 2, 10.0});
    scene.gravity = Vec3(0.2, -0.1, -0.8);
    return scene;
  }
  static FemOptions options(FemElement element) {
    FemOptions out;
    out.element = element;
    return out;
  }
};

}  // namespace

TEST_CASE("sensitivities by material and gravity are those of differences", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  Pushed body(element);
  const std::vector<std::pair<std::string, double>> parameters{
      {"youngs_modulus", 1e-3}, {"poissons_ratio", 1e-5}, {"density", 1e-3}, {"gravity_x", 1e-3}, {"gravity_z", 1e-3}};
  for (const auto& [name, step] : parameters) {
    const FemPerturbation perturbation = FemSensitivity(body.equilibrium_, body.state_).by_parameter(name);
    double value = 0.0;
    for (const auto& term : body.model_.terms())
      for (std::size_t k = 0; k < term->parameters().size(); ++k)
        if (term->parameters()[k].name == name) value = term->parameter(static_cast<int>(k));
    const auto set = [&, key = name](double h) { body.model_.set_parameter(key, value + h); };
    body.check(name, perturbation, step, set);
  }
}

TEST_CASE("sensitivities by a pad's pose are those of differences", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  Pushed body(element);
  const PadInput pose = body.pads_[0];
  const Vec3 axis = Vec3(0.6, 0.0, 0.8);
  const FemSensitivity sensitivity(body.equilibrium_, body.state_);
  body.check("shift", sensitivity.by_pad_shift(0, axis), 1e-4,
             [&](double h) { body.pads_[0].center = pose.center + h * axis; });
  body.check("turn", sensitivity.by_pad_turn(0, axis, pose.center), 1e-5,
             [&](double h) { body.pads_[0].rotation = Eigen::AngleAxisd(h, axis) * pose.rotation; });
}

TEST_CASE("sensitivities by a field of stiffness are those of differences, and the map holds them all", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  Pushed body(element);
  FemSolid& solid = body.model_.solid();
  const int points = solid.points_per_element();
  std::vector<double> field;
  for (int e = 0; e < solid.entity_count(); ++e)
    for (int q = 0; q < points; ++q)
      field.push_back(std::exp(-0.01 * (solid.rest_of_point(e, q) - Vec3(8, 8, 12)).squaredNorm()));
  const auto set = [&](const std::vector<double>& direction, double h) {
    std::vector<double> factors;
    for (double weight : direction) factors.push_back(std::exp(h * weight));
    solid.set_stiffness(factors);
  };
  const FemSensitivity sensitivity(body.equilibrium_, body.state_);
  body.check("field", sensitivity.by_log_stiffness(field), 1e-3, [&](double h) { set(field, h); });

  const std::vector<double> map =
      sensitivity.by_element_stiffness(sensitivity.adjoint(sensitivity.of_pad_force(0, Vec3::UnitZ())));
  for (int e : {0, 17, solid.entity_count() - 1}) {
    std::vector<double> one(field.size(), 0.0);
    std::fill_n(one.begin() + e * points, points, 1.0);
    body.check("element", sensitivity.by_log_stiffness(one), 1e-3, [&](double h) { set(one, h); });
    FemSensitivity again(body.equilibrium_, body.state_);
    const FemResponse response = again.response(again.by_log_stiffness(one));
    CHECK(map[e] == Approx(derivative(again.of_pad_force(0, Vec3::UnitZ()), response)).epsilon(1e-8).margin(1e-12));
  }
}
