#include "core/fem_model.hpp"

#include <algorithm>
#include <cstdio>

#include "core/fem_gravity.hpp"
#include "core/fem_neo_hookean.hpp"
#include "core/scene_places.hpp"

namespace tissued::core {

namespace {

FemPhysics standard_physics(const Scene& scene, const FemMesh& mesh, MassMatrix mass) {
  FemPhysics physics;
  physics.laws.push_back(std::make_unique<FemNeoHookean>(scene.material));
  physics.terms.push_back(std::make_unique<FemGravity>(mesh, scene.gravity, scene.material.density));
  physics.masses.push_back(std::make_unique<FemInertia>(mesh, scene.material.density, mass));
  physics.fixed_nodes = nodes_of(mesh, surface_of(scene.mesh, scene.fixed_surface, "the support"));
  return physics;
}

// True where it has the parameter.
bool set_in(FemAdjustable& owner, const std::string& name, double value) {
  bool found = false;
  for (std::size_t k = 0; k < owner.parameters().size(); ++k) {
    const FemParameter& parameter = owner.parameters()[k];
    if (parameter.name != name) continue;
    if (!(value >= parameter.lowest && value <= parameter.highest)) {
      char limits[120];
      std::snprintf(limits, sizeof limits, " = %g is not within %g and %g ", value, parameter.lowest,
                    parameter.highest);
      throw ModelError(name + limits + parameter.unit);
    }
    owner.set_parameter(static_cast<int>(k), value);
    found = true;
  }
  return found;
}

}  // namespace

FemModel::FemModel(const Scene& scene, const FemOptions& options)
    : scene_((check_scene(scene), scene)), mesh_(make_fem_mesh(scene_.mesh, options.element)) {
  FemPhysics physics = standard_physics(scene_, mesh_, options.mass);
  for (const FemEffect& effect : options.effects) effect(scene_, mesh_, physics);
  const bool remembers = std::any_of(physics.laws.begin(), physics.laws.end(),
                                     [](const auto& law) { return law->history_per_point() > 0; });
  const int usual = options.element == FemElement::p1 ? 1 : remembers ? 2 : 3;
  const int degree = options.quadrature_degree > 0 ? options.quadrature_degree : usual;

  auto solid =
      std::make_unique<FemSolid>(mesh_, tet_quadrature(degree), std::move(physics.laws), std::move(physics.fields));
  solid_ = solid.get();
  terms_.push_back(std::move(solid));
  for (auto& term : physics.terms) terms_.push_back(std::move(term));
  masses_ = std::move(physics.masses);
  dampings_ = std::move(physics.dampings);
  other_names_ = std::move(physics.other_names);
  pads_hold_ = physics.pads_hold;
  for (const auto* group : {&terms_, &masses_})
    for (const auto& term : *group) adjustables_.push_back(term.get());
  for (const auto& damping : dampings_) adjustables_.push_back(damping.get());
  pattern_ = make_fem_pattern(mesh_.node_count(), terms_);

  fixed_.assign(static_cast<std::size_t>(mesh_.node_count()), 0);
  for (int node : physics.fixed_nodes) fixed_[node] = 1;
  for (const Pad& pad : scene_.pads) {
    const SurfaceGroup& group = surface_of(scene_.mesh, pad.surface, "pad " + pad.name);
    pad_nodes_.push_back(nodes_of(mesh_, group));
    pad_shares_.push_back(shares_of(mesh_, group));
  }
  for (const MaterialPoint& point : points_of_markers(scene_)) marker_points_.push_back(fem_point(mesh_, point));
  for (const MaterialPoint& point : points_of_targets(scene_)) target_points_.push_back(fem_point(mesh_, point));
}

const std::string& FemModel::own_name(const std::string& name) const {
  const auto other = other_names_.find(name);
  return other == other_names_.end() ? name : other->second;
}

void FemModel::set_parameter(const std::string& name, double value) {
  bool found = false;
  for (FemAdjustable* owner : adjustables_) found = set_in(*owner, own_name(name), value) || found;
  if (!found) throw ModelError("the body has no parameter " + name);
  ++revision_;
}

double FemModel::parameter(const std::string& name) const {
  for (const FemAdjustable* owner : adjustables_)
    for (std::size_t k = 0; k < owner->parameters().size(); ++k)
      if (owner->parameters()[k].name == own_name(name)) return owner->parameter(static_cast<int>(k));
  throw ModelError("the body has no parameter " + name);
}

RayleighDamping FemModel::damping() const {
  RayleighDamping sum;
  for (const auto& damping : dampings_) {
    sum.mass += damping->rates().mass;
    sum.stiffness += damping->rates().stiffness;
  }
  return sum;
}

Eigen::VectorXd FemModel::rest() const {
  return Eigen::Map<const Eigen::VectorXd>(mesh_.rest.data(), mesh_.rest.size());
}

}  // namespace tissued::core
