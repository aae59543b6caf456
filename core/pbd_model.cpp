#include "core/pbd_model.hpp"

#include <algorithm>

#include "core/scene_places.hpp"

namespace tissued::core {

namespace {

constexpr double kBaseReach = 0.5;  // spacings from the fixed surface within which particles are held
// Spacings from a pad's facets within which particles go with it: as deep as holds one particle under every facet of a
// curved skin, too.
constexpr double kPadReach = 1.0;
constexpr double kRounding = 1e-9;

// Particles within `reach` mm of the facets.
std::vector<int> particles_near(const TetMesh& mesh, const SurfaceGroup& group, const ParticleLattice& lattice,
                                double reach) {
  Vec3 low = mesh.node(group.triangles.front()[0]), high = low;
  for (int node : nodes_of(group)) {
    low = low.cwiseMin(mesh.node(node));
    high = high.cwiseMax(mesh.node(node));
  }
  reach *= 1.0 + kRounding;
  std::vector<int> near;
  for (int i = 0; i < lattice.count(); ++i) {
    const Vec3& p = lattice.rest(i);
    if (((p - low).array() < -reach).any() || ((p - high).array() > reach).any()) continue;
    if (locate_on_surface(mesh, group.triangles, p).distance <= reach) near.push_back(i);
  }
  return near;
}

const Scene& checked(const Scene& scene) {
  check_scene(scene);
  return scene;
}

NodeField rest_of(const ParticleLattice& lattice) {
  NodeField rest = NodeField::Zero(lattice.count(), 4);
  for (int i = 0; i < lattice.count(); ++i) rest.row(i).head<3>() = lattice.rest(i).transpose();
  return rest;
}

double mass_of(const Scene& scene) {
  double volume = 0.0;
  for (const Tet& tet : scene.mesh.tets) volume += signed_volume(scene.mesh, tet);
  return scene.material.density * volume * kKilogramPerDensityVolume;
}

ParticleReadout read_nodes(const Scene& scene, const ParticleLattice& lattice, PbdReadout kind) {
  std::vector<ParticleReadout::Point> points;
  for (int i = 0; i < scene.mesh.node_count(); ++i) points.push_back({scene.mesh.node(i), scene.mesh.node(i)});
  return {lattice, kind, points};
}

ParticleReadout read_points(const Scene& scene, const ParticleLattice& lattice, PbdReadout kind,
                            const std::vector<MaterialPoint>& places) {
  std::vector<ParticleReadout::Point> points;
  for (const MaterialPoint& place : places) points.push_back(ParticleReadout::point_at(scene.mesh, place));
  return {lattice, kind, points};
}

}  // namespace

PbdModel::PbdModel(const Scene& scene_in, const PbdOptions& options_in)
    : scene(checked(scene_in)),
      options(options_in),
      lattice(scene.mesh, options.particle_spacing),
      clusters(lattice, options.cluster_spacing, options.cluster_radius),
      rest(rest_of(lattice)),
      mobility(static_cast<std::size_t>(lattice.count()), 1.0),
      particle_mass(mass_of(scene) / lattice.count()),
      gravity(Eigen::RowVector4d::Zero()),
      nodes(read_nodes(scene, lattice, options.readout)),
      markers(read_points(scene, lattice, options.readout, points_of_markers(scene))),
      targets(read_points(scene, lattice, options.readout, points_of_targets(scene))) {
  gravity.head<3>() = kStandardGravity * scene.gravity.transpose();
  hold_base();
  glue_pads();
}

void PbdModel::hold_base() {
  const SurfaceGroup& base = surface_of(scene.mesh, scene.fixed_surface, "the fixed surface");
  const std::vector<int> held = particles_near(scene.mesh, base, lattice, kBaseReach * lattice.spacing());
  if (held.empty())
    throw ModelError("no particle is within half of simulator.pbd.particle_spacing " +
                     std::to_string(lattice.spacing()) + " mm of the fixed surface \"" + scene.fixed_surface + "\"");
  for (int i : held) mobility[static_cast<std::size_t>(i)] = 0.0;
}

void PbdModel::glue_pads() {
  for (const Pad& pad : scene.pads) {
    const SurfaceGroup& facets = surface_of(scene.mesh, pad.surface, "pad " + pad.name);
    std::vector<int> glued = particles_near(scene.mesh, facets, lattice, kPadReach * lattice.spacing());
    std::erase_if(glued, [this](int i) { return mobility[static_cast<std::size_t>(i)] == 0.0; });
    if (glued.empty())
      throw ModelError("no free particle is within simulator.pbd.particle_spacing " +
                       std::to_string(lattice.spacing()) + " mm of pad " + pad.name);
    pad_particles.push_back(std::move(glued));
  }
}

}  // namespace tissued::core
