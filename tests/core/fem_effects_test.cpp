// What a new physical effect needs: terms and laws of its own, memory at the quadrature points, nodes let go.
#include <catch2/catch.hpp>

#include "core/fem_sensitivity.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

constexpr double kSpring = 40.0;  // mN/mm
constexpr double kTau = 0.5;      // s

// A spring from every node of a list to where it is at rest: a term of single nodes.
class Springs final : public FemTerm {
 public:
  Springs(const FemMesh& mesh, std::vector<int> nodes, double stiffness)
      : mesh_(&mesh), nodes_(std::move(nodes)), stiffness_(stiffness) {}
  std::string_view name() const override { return "springs"; }
  int entity_count() const override { return static_cast<int>(nodes_.size()); }
  int nodes_per_entity() const override { return 1; }
  std::span<const int> nodes_of_entity(int entity) const override { return {&nodes_[entity], 1}; }
  void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const override {
    for (int e = begin; e < end; ++e) {
      const Vec3 stretch = stretch_of(e, input);
      if (output.energy != nullptr) output.energy[e] = 0.5 * stiffness_ * stretch.squaredNorm();
      if (output.residual != nullptr) Eigen::Map<Vec3>(output.residual + 3 * e) = stiffness_ * stretch;
      if (output.tangent != nullptr) Eigen::Map<Mat3>(output.tangent + 9 * e) = stiffness_ * Mat3::Identity();
    }
  }
  std::span<const FemParameter> parameters() const override {
    static const std::array<FemParameter, 1> kParameters{{{"spring", "mN/mm", 0.0, 1e9}}};
    return kParameters;
  }
  double parameter(int) const override { return stiffness_; }
  void set_parameter(int, double value) override { stiffness_ = value; }
  bool has_derivative(int) const override { return true; }
  void differentiate(int, int begin, int end, const TermInput& input, double* residual) const override {
    for (int e = begin; e < end; ++e) Eigen::Map<Vec3>(residual + 3 * e) = stretch_of(e, input);
  }

 private:
  Vec3 stretch_of(int e, const TermInput& input) const {
    return Eigen::Map<const Vec3>(input.x + 3 * nodes_[e]) - mesh_->rest.row(nodes_[e]).transpose();
  }
  const FemMesh* mesh_;
  std::vector<int> nodes_;
  double stiffness_;
};

// A stress that relaxes, P = g (F - V) with V' = (F - V) / tau by implicit Euler; remembers V - I.
class Relaxing final : public FemLaw {
 public:
  Relaxing(double stiffness, double tau) : stiffness_(stiffness), tau_(tau) {}
  std::string_view name() const override { return "relaxing"; }
  void add(const PointBatch& batch, const PointDeformation& deformation, bool tangent,
           PointResponse& response) const override {
    const double left = 1.0 / (1.0 + batch.time_step / tau_);
    for (int k = 0; k < 9; ++k) {
      for (int l = 0; l < kPointLanes; ++l) {
        const double stretch = left * (deformation.f[k][l] - (k % 4 == 0) - batch.history[k * kPointLanes + l]);
        response.stress[k][l] += stiffness_ * stretch;
        if (tangent) response.tangent[pair_index(k, k)][l] += stiffness_ * left;
      }
    }
  }
  int history_per_point() const override { return 9; }
  void accept(const PointBatch& batch, const PointDeformation& deformation, double* history) const override {
    const double rate = batch.time_step / tau_;
    for (int k = 0; k < 9 * kPointLanes; ++k) {
      const double f = deformation.f[k / kPointLanes][k % kPointLanes] - (k / kPointLanes % 4 == 0);
      history[k] = (batch.history[k] + rate * f) / (1.0 + rate);
    }
  }

 private:
  double stiffness_, tau_;
};

PadInput pushed(const Pad& pad, const Vec3& way) {
  PadInput input;
  input.kind = PadInput::Kind::pose;
  input.center = pad.center + way;
  return input;
}

}  // namespace

TEST_CASE("a body whose base is let go onto springs rests on their sum", "[fem]") {
  Scene scene = box_scene({2, 2, 2, 10.0});
  scene.gravity = Vec3(0.0, 0.0, -1.0);
  FemOptions options;
  options.effects.push_back([](const Scene& s, const FemMesh& mesh, FemPhysics& physics) {
    physics.terms.push_back(std::make_unique<Springs>(mesh, nodes_of(mesh, *s.mesh.find_surface("base")), kSpring));
    physics.fixed_nodes.clear();
  });
  FemModel model(scene, options);
  FemEquilibrium equilibrium(model, 1);
  FemState state = rest_state(model);
  const std::vector<PadInput> pads(2);
  REQUIRE(solve_static(equilibrium, state, {pads}, FemControl{}).converged);
  double sunk = 0.0;
  for (int node : nodes_of(model.mesh(), *scene.mesh.find_surface("base"))) sunk -= state.x[3 * node + 2];
  const double weight = 1e-6 * 20.0 * 20.0 * 20.0 * 9806.65;  // mN
  CHECK(kSpring * sunk == Approx(weight).epsilon(1e-9));

  FemSensitivity sensitivity(equilibrium, state);
  const FemPerturbation spring = sensitivity.by_parameter("spring");
  const double slope = derivative(sensitivity.of_target(0, Vec3::UnitZ()), sensitivity.response(spring));
  const auto height = [&](double stiffness) {
    model.set_parameter("spring", stiffness);
    FemState moved = rest_state(model);
    REQUIRE(solve_static(equilibrium, moved, {pads}, FemControl{}).converged);
    return position_of(model.target_points()[0], moved.x).z();
  };
  CHECK(slope == Approx((height(kSpring + 0.01) - height(kSpring - 0.01)) / 0.02).epsilon(1e-5));
}

TEST_CASE("a law with memory relaxes under a hold, and failed or repeated solves leave its memory alone", "[fem]") {
  const auto element = GENERATE(FemElement::p1, FemElement::p2);
  const Scene scene = box_scene({2, 2, 1, 10.0});
  constexpr double kStep = 0.1, kModulus = 4.0;
  const auto effect = [](double stiffness) {
    FemOptions options;
    options.effects.push_back([stiffness](const Scene&, const FemMesh&, FemPhysics& physics) {
      physics.laws.push_back(std::make_unique<Relaxing>(stiffness, kTau));
    });
    return options;
  };
  FemOptions with = effect(kModulus);
  with.element = element;
  const FemModel model(scene, with);
  FemEquilibrium equilibrium(model, 1);
  FemState state = rest_state(model);
  // Every node held: the deformation is prescribed, and the relaxing stress must fall by 1 / (1 + dt / tau) a step.
  FemHold hold = hold_of(model, std::vector<PadInput>(2));
  std::fill(hold.held.begin(), hold.held.end(), std::uint8_t{1});
  hold.held.back() = 0;
  hold.position = state.x;
  for (int i = 0; i < model.mesh().node_count(); ++i) hold.position[3 * i] += 0.1 * model.mesh().rest(i, 2);
  FemBalance balance;
  balance.time_step = kStep;
  balance.offset.setZero(state.x.size());
  Eigen::VectorXd elastic, forces;
  std::vector<double> overstress;
  for (int n = 0; n < 6; ++n) {
    REQUIRE(equilibrium.find(balance, hold, state.history, FemControl{}, state.x).converged);
    const FemHistory before = state.history;
    REQUIRE(equilibrium.find(balance, hold, state.history, FemControl{}, state.x).converged);
    REQUIRE(before == state.history);
    equilibrium.terms(hold.position, kStep, state.history, forces);
    FemOptions plain;
    plain.element = element;
    const FemModel neo_hookean(scene, plain);
    FemEquilibrium other(neo_hookean, 1);
    other.terms(hold.position, 0.0, rest_state(neo_hookean).history, elastic);
    overstress.push_back((forces - elastic).norm());
    equilibrium.accept(hold.position, kStep, state.history);
  }
  REQUIRE(overstress[0] > 1.0);
  for (std::size_t n = 1; n < overstress.size(); ++n)
    CHECK(overstress[n] == Approx(overstress[n - 1] / (1.0 + kStep / kTau)).epsilon(1e-9));
}

TEST_CASE("a stiffer field answers as a stiffer material", "[fem]") {
  Scene scene = box_scene({2, 2, 2, 10.0});
  FemModel model(scene, {});
  const std::vector<PadInput> pads{pushed(scene.pads[0], Vec3(0.0, 0.5, -2.0)), PadInput{}};
  FemEquilibrium equilibrium(model, 1);
  FemState state = rest_state(model);
  REQUIRE(solve_static(equilibrium, state, {pads}, FemControl{}).converged);
  const Vec3 soft = pad_forces(state, pads)[0];
  const std::size_t points = static_cast<std::size_t>(scene.mesh.tet_count() * model.solid().points_per_element());
  model.solid().set_stiffness(std::vector<double>(points, 2.5));
  REQUIRE(solve_static(equilibrium, state, {pads}, FemControl{}).converged);
  CHECK((pad_forces(state, pads)[0] - 2.5 * soft).norm() < 1e-8);
}
