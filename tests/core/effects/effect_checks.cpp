#include "tests/core/effects/effect_checks.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/fem_neo_hookean.hpp"

namespace tissued::core::testing {

namespace {

FemOptions options_with(const Effect& effect, FemElement element) {
  FemOptions options;
  options.element = element;
  options.effects.push_back(fem_effect(effect));
  return options;
}

Eigen::VectorXd disturbed(const FemModel& model, double size, unsigned seed) {
  std::mt19937 generator(seed);
  Eigen::VectorXd x = model.rest();
  for (double& entry : x) entry += size * symmetric_random(generator);
  return x;
}

Mat3 bar(double along, double across) { return Vec3(along, across, across).asDiagonal(); }

PointDeformation in_all_lanes(const Mat3& f) {
  PointDeformation deformation;
  for (int k = 0; k < 9; ++k) std::fill_n(deformation.f[k], kPointLanes, f(k / 3, k % 3));
  return deformation;
}

}  // namespace

std::vector<double> chosen_values(const Effect& effect, const Scene& scene, const std::vector<Chosen>& chosen) {
  std::vector<double> values = effect.neutral(scene);
  for (const Chosen& choice : chosen) {
    bool known = false;
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (effect.parameters()[k].name != choice.name) continue;
      values[k] = choice.value;
      known = true;
    }
    INFO(choice.name);
    REQUIRE(known);
  }
  return values;
}

PadInput pushed(const Pad& pad, const Vec3& way) {
  PadInput input;
  input.kind = PadInput::Kind::pose;
  input.center = pad.center + way;
  return input;
}

FemState solved(const FemModel& model, const std::vector<PadInput>& pads) {
  FemEquilibrium equilibrium(model, 1);
  FemState state = rest_state(model);
  const FemReport report = solve_static(equilibrium, state, {pads, nullptr}, FemControl{});
  INFO(report.words());
  REQUIRE(report.converged);
  return state;
}

void check_derivatives(const Effect& effect, const std::vector<Chosen>& chosen) {
  constexpr double kStep = 1e-5, kTimeStep = 0.2;
  Scene scene = box_scene({2, 2, 1, 10.0});
  scene.gravity = Vec3(0.2, 0.0, -1.0);
  for (const FemElement element : {FemElement::p1, FemElement::p2}) {
    FemModel model(scene, options_with(effect, element));
    set_effect(model, effect, chosen_values(effect, scene, chosen));
    FemEquilibrium equilibrium(model, 1);
    FemHistory history = rest_state(model).history;
    equilibrium.accept(disturbed(model, 1.0, 3), 0.3, history);
    const Eigen::VectorXd x = disturbed(model, 0.8, 5);
    Eigen::VectorXd residual, plus, minus, product;
    std::vector<double> values;
    const double energy = equilibrium.terms(x, kTimeStep, history, residual, &values);
    REQUIRE(std::isfinite(energy));
    for (unsigned seed = 0; seed < 4; ++seed) {
      const Eigen::VectorXd way = disturbed(model, 1.0, 10 + seed) - model.rest();
      const double above = equilibrium.terms(x + kStep * way, kTimeStep, history, plus);
      const double below = equilibrium.terms(x - kStep * way, kTimeStep, history, minus);
      CHECK(residual.dot(way) == Approx((above - below) / (2.0 * kStep)).epsilon(1e-6).margin(1e-5));
      model.pattern().multiply(values, way, product);
      CHECK((product - (plus - minus) / (2.0 * kStep)).norm() < 1e-6 * (1.0 + product.norm()));
    }
  }
}

void check_neutral(const Effect& effect, double tolerance) {
  Scene scene = box_scene({3, 2, 2, 10.0});
  scene.gravity = Vec3(0.0, 0.1, -1.0);
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(0.3, 0.0, -2.0)), PadInput{}};
  std::vector<FemState> states;
  FemOptions plain;
  plain.element = FemElement::p1;
  const FemModel without(scene, plain), with(scene, options_with(effect, FemElement::p1));
  for (const FemModel* model : {&without, &with}) {
    FemEquilibrium equilibrium(*model, 1);
    states.push_back(rest_state(*model));
    for (int step = 0; step < 2; ++step)
      REQUIRE(solve_static(equilibrium, states.back(), {pads}, FemControl{}, 0.2).converged);
  }
  CHECK((states[0].x - states[1].x).cwiseAbs().maxCoeff() < tolerance);
  CHECK((pad_forces(states[0], pads)[0] - pad_forces(states[1], pads)[0]).norm() < 10.0 * tolerance);
}

void check_words(const Effect& effect, const std::vector<Chosen>& chosen) {
  const Scene scene = box_scene({2, 2, 1, 10.0});
  CHECK(find_effect(effect.kind()) == &effect);
  CHECK(!effect.title().empty());
  const std::vector<double> neutral = effect.neutral(scene);
  REQUIRE(neutral.size() == effect.parameters().size());
  for (std::size_t k = 0; k < neutral.size(); ++k) {
    const EffectParameter& parameter = effect.parameters()[k];
    INFO(parameter.name);
    CHECK(parameter.lowest < parameter.highest);
    CHECK(neutral[k] >= parameter.lowest);
    CHECK(neutral[k] <= parameter.highest);
    CHECK(parameter.typical > 0.0);
    CHECK(!parameter.unit.empty());
    if (parameter.logarithmic) CHECK(parameter.lowest > 0.0);
  }
  const std::vector<double> values = chosen_values(effect, scene, chosen);
  const std::string sentence = effect.sentence(values);
  CHECK(sentence.size() > 20);
  CHECK(sentence.back() == '.');
  CHECK(sentence.find("nan") == std::string::npos);
  for (const EffectNumber& number : effect.reported(values)) CHECK(std::isfinite(number.value));
}

MaterialPointTwin::MaterialPointTwin(const Effect& effect, const Scene& scene, const std::vector<Chosen>& chosen) {
  FemPhysics physics;
  physics.laws.push_back(std::make_unique<FemNeoHookean>(scene.material));
  effect.add_to(scene, make_fem_mesh(scene.mesh, FemElement::p1), physics);
  laws_ = std::move(physics.laws);
  const std::vector<double> values = chosen_values(effect, scene, chosen);
  for (const auto& law : laws_) {
    for (std::size_t k = 0; k < values.size(); ++k)
      for (std::size_t i = 0; i < law->parameters().size(); ++i)
        if (law->parameters()[i].name == model_parameter(effect, effect.parameters()[k]))
          law->set_parameter(static_cast<int>(i), values[k]);
    history_.emplace_back(static_cast<std::size_t>(law->history_per_point() * kPointLanes), 0.0);
  }
}

Mat3 MaterialPointTwin::stress(const Mat3& f, double time_step) const {
  PointResponse response{};
  for (std::size_t k = 0; k < laws_.size(); ++k)
    laws_[k]->add({0, time_step, history_[k].data()}, in_all_lanes(f), false, response);
  Mat3 stress;
  for (int k = 0; k < 9; ++k) stress(k / 3, k % 3) = response.stress[k][3];
  return stress;
}

void MaterialPointTwin::accept(const Mat3& f, double time_step) {
  for (std::size_t k = 0; k < laws_.size(); ++k)
    if (!history_[k].empty()) laws_[k]->accept({0, time_step, history_[k].data()}, in_all_lanes(f), history_[k].data());
}

double MaterialPointTwin::across(double along, double time_step) const {
  double low = 0.3, high = 3.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (stress(bar(along, middle), time_step)(1, 1) < 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double MaterialPointTwin::bar_stress(double along, double time_step) const {
  return stress(bar(along, across(along, time_step)), time_step)(0, 0);
}

void MaterialPointTwin::accept_bar(double along, double time_step) {
  accept(bar(along, across(along, time_step)), time_step);
}

}  // namespace tissued::core::testing
