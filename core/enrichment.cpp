#include "core/enrichment.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/damping_laws.hpp"
#include "core/scene_places.hpp"

namespace tissued::core {

namespace {

void check(std::span<const EffectSetting> effects) {
  for (std::size_t i = 0; i < effects.size(); ++i) {
    const Effect& effect = *effects[i].effect;
    for (std::size_t k = 0; k < i; ++k)
      if (effects[k].effect == &effect) throw ModelError(std::string(effect.kind()) + " is given twice");
    for (std::size_t k = 0; k < effect.parameters().size(); ++k) {
      const EffectParameter& p = effect.parameters()[k];
      if (!(effects[i].values[k] >= p.lowest && effects[i].values[k] <= p.highest))
        throw ModelError(model_parameter(effect, p) + " = " + std::to_string(effects[i].values[k]) + " is not within " +
                         std::to_string(p.lowest) + " and " + std::to_string(p.highest) + " " + p.unit);
    }
  }
}

void set(FemAdjustable& owner, const std::map<std::string, double>& values) {
  for (std::size_t k = 0; k < owner.parameters().size(); ++k)
    if (const auto value = values.find(owner.parameters()[k].name); value != values.end())
      owner.set_parameter(static_cast<int>(k), value->second);
}

}  // namespace

Enrichment::Enrichment(const Scene& scene, std::span<const EffectSetting> effects)
    : scene_((check(effects), adjusted(scene, effects))), mesh_(make_fem_mesh(scene_.mesh, FemElement::p1)) {
  const std::vector<int> support = nodes_of(mesh_, surface_of(scene_.mesh, scene_.fixed_surface, "the support"));
  physics_.fixed_nodes = support;
  std::map<std::string, double> values;
  for (const EffectSetting& setting : effects) {
    setting.effect->add_to(scene_, mesh_, physics_);
    for (std::size_t k = 0; k < setting.values.size(); ++k)
      values[model_parameter(*setting.effect, setting.effect->parameters()[k])] = setting.values[k];
  }
  support_holds_ = physics_.fixed_nodes == support;
  for (const auto& law : physics_.laws) set(*law, values);
  for (const auto* group : {&physics_.terms, &physics_.masses})
    for (const auto& term : *group) set(*term, values);
  for (const auto& field : physics_.fields) set(*field, values);
  for (const auto& damping : physics_.dampings) {
    set(*damping, values);
    damping_.mass += damping->rates().mass;
    damping_.stiffness += damping->rates().stiffness;
  }
  if (damping_.stiffness > 0.0) add_damping_laws(scene_.material, damping_.stiffness, physics_.laws);
}

Eigen::VectorXd Enrichment::rest() const {
  return Eigen::Map<const Eigen::VectorXd>(mesh_.rest.data(), mesh_.rest.size());
}

// The mean over points halfway from the domain's middle to its nodes, which surround the domain.
double Enrichment::factor(const StrainDomain& domain) const {
  if (physics_.fields.empty()) return 1.0;
  Vec3 middle = Vec3::Zero();
  for (int anchor : domain.anchors) middle += scene_.mesh.node(anchor) / static_cast<double>(domain.anchors.size());
  double sum = 0.0;
  for (int node : domain.nodes) {
    const Vec3 place = 0.5 * (middle + scene_.mesh.node(node));
    double log_factor = 0.0;
    for (const auto& field : physics_.fields) log_factor += field->log_factor(place);
    sum += std::exp(log_factor);
  }
  return sum / static_cast<double>(domain.nodes.size());
}

// Of an even motion by 1 mm: the rows' sums.
Eigen::VectorXd Enrichment::added_masses() const {
  Eigen::VectorXd masses = Eigen::VectorXd::Zero(mesh_.node_count());
  const Eigen::VectorXd moved = Eigen::VectorXd::Ones(3 * masses.size());
  for (const auto& term : physics_.masses) {
    const int nodes = term->nodes_per_entity();
    std::vector<double> residual(static_cast<std::size_t>(3 * nodes * term->entity_count()));
    term->evaluate(0, term->entity_count(), {moved.data(), 0.0, nullptr, {}}, {nullptr, residual.data(), nullptr});
    for (int e = 0; e < term->entity_count(); ++e)
      for (int a = 0; a < nodes; ++a)
        masses[term->nodes_of_entity(e)[a]] += residual[static_cast<std::size_t>(3 * (e * nodes + a))];
  }
  return masses;
}

std::vector<HeldAxes> Enrichment::held_axes(std::span<const int> nodes, const Eigen::VectorXd& limit) const {
  std::vector<Mat3> stiffness(static_cast<std::size_t>(mesh_.node_count()), Mat3::Zero());
  std::vector<PadInput> resting;
  for (const Pad& pad : scene_.pads) {
    resting.emplace_back();
    resting.back().kind = PadInput::Kind::pose;
    resting.back().center = pad.center;
  }
  const Eigen::VectorXd x = rest();
  for (const auto& term : physics_.terms) {
    if (!term->has_tangent()) continue;
    const int count = term->nodes_per_entity(), pairs = pair_count(count);
    const std::vector<double> history(term->history_size(), 0.0);
    std::vector<double> tangent(static_cast<std::size_t>(9 * pairs * term->entity_count()));
    term->evaluate(0, term->entity_count(), {x.data(), 0.0, history.data(), resting},
                   {nullptr, nullptr, tangent.data()});
    for (int e = 0; e < term->entity_count(); ++e)
      for (int a = 0; a < count; ++a)
        for (int b = 0; b <= a; ++b) {  // rows' sums: consistent springs as if they were at the nodes
          const Eigen::Map<const Mat3> block(tangent.data() + 9 * (e * pairs + pair_index(a, b)));
          stiffness[term->nodes_of_entity(e)[a]] += block;
          if (a != b) stiffness[term->nodes_of_entity(e)[b]] += block;
        }
  }
  std::vector<HeldAxes> out;
  for (int node : nodes) {
    const Eigen::SelfAdjointEigenSolver<Mat3> spectrum(stiffness[node]);  // ascending
    HeldAxes held;
    held.axes = spectrum.eigenvectors().rowwise().reverse();
    held.count = 0;
    for (int axis = 2; axis >= 0 && spectrum.eigenvalues()[axis] > limit[node]; --axis) ++held.count;
    if (held.count == 3) held.axes.setIdentity();
    out.push_back(held);
  }
  return out;
}

}  // namespace tissued::core
