#include "tests/study/random_scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "tests/study/body.hpp"

namespace tissued::study {

namespace {

using core::Scene;
using core::Vec3;

Vec3 normal_of(const core::TetMesh& mesh, const core::Triangle& facet) {
  const Vec3 a = mesh.node(facet[0]);
  return (mesh.node(facet[1]) - a).cross(mesh.node(facet[2]) - a);
}

// Pressed in along the mean normal of its patch, at a slant of some degrees.
core::Pad pad_on(const core::TetMesh& mesh, const std::string& name, Random& random) {
  const core::SurfaceGroup& patch = *mesh.find_surface(name);
  core::Pad pad{name, name, Vec3::Zero(), Vec3::Zero()};
  const std::vector<int> nodes = core::nodes_of(patch);
  for (int node : nodes) pad.center += mesh.node(node) / static_cast<double>(nodes.size());
  for (const core::Triangle& facet : patch.triangles) pad.direction -= normal_of(mesh, facet);
  pad.direction = (pad.direction.normalized() + 0.1 * random.normal_vector()).normalized();
  return pad;
}

// A place of the skin, as likely here as there.
Vec3 place_on_skin(const core::TetMesh& mesh, Random& random) {
  const std::vector<core::Triangle>& skin = mesh.find_surface("skin")->triangles;
  double area = 0.0;
  for (const core::Triangle& facet : skin) area += normal_of(mesh, facet).norm();
  double left = area * random.uniform(0.0, 1.0);
  std::size_t k = 0;
  while (k + 1 < skin.size() && (left -= normal_of(mesh, skin[k]).norm()) > 0.0) ++k;
  double a = random.uniform(0.0, 1.0), b = random.uniform(0.0, 1.0);
  if (a + b > 1.0) a = 1.0 - a, b = 1.0 - b;
  const Vec3 origin = mesh.node(skin[k][0]);
  return origin + a * (mesh.node(skin[k][1]) - origin) + b * (mesh.node(skin[k][2]) - origin);
}

Vec3 place_inside(const core::TetMesh& mesh, Random& random) {
  const core::Tet& tet = mesh.tets[static_cast<std::size_t>(random.integer(0, mesh.tet_count() - 1))];
  return 0.25 * (mesh.node(tet[0]) + mesh.node(tet[1]) + mesh.node(tet[2]) + mesh.node(tet[3]));
}

}  // namespace

void add_pads(Scene& scene, Random& random) {
  const int wanted = random.integer(1, 3);
  const Vec3 size = (scene.mesh.rest.colwise().maxCoeff() - scene.mesh.rest.colwise().minCoeff()).transpose();
  constexpr int kAttempts = 100;
  for (int attempt = 0; attempt < kAttempts && static_cast<int>(scene.pads.size()) < wanted; ++attempt) {
    const std::vector<core::Triangle>& skin = scene.mesh.find_surface("skin")->triangles;
    const core::Triangle& facet = skin[static_cast<std::size_t>(random.integer(0, static_cast<int>(skin.size()) - 1))];
    const Vec3 middle = scene.mesh.node(facet[0]);
    const double radius = size.x() * random.uniform(0.1, 0.2);
    if (middle.z() < 0.5 * size.z()) continue;
    std::string name = "A";
    name += std::to_string(scene.pads.size() + 1);
    if (cut_patch(scene.mesh, name, middle, radius)) scene.pads.push_back(pad_on(scene.mesh, name, random));
  }
}

void add_points(double offset, Random& random, Scene& scene, Scene& truth) {
  const int markers = random.integer(8, 24), targets = random.integer(1, 4);
  for (int i = 0; i < markers; ++i) {
    std::string name = "M";
    name += std::to_string(i + 1);
    const Vec3 place = place_on_skin(truth.mesh, random);
    truth.markers.push_back({name, place});
    scene.markers.push_back({name, place + offset * random.normal_vector()});
  }
  for (int i = 0; i < targets; ++i) {
    std::string name = "T";
    name += std::to_string(i + 1);
    scene.targets.push_back({name, place_inside(scene.mesh, random)});
  }
  truth.targets = scene.targets;
}

std::vector<Push> random_pushes(const Scene& scene, Random& random) {
  const double height = scene.mesh.rest.col(2).maxCoeff();
  const double deepest = std::min(15.0, 0.25 * height);
  const auto depth = [&] { return random.uniform(3.0, std::max(3.1, deepest)); };
  std::vector<Push> pushes;
  const int pads = static_cast<int>(scene.pads.size());
  for (int pad = 0; pad < std::min(pads, 3); ++pad) pushes.push_back({{pad}, {depth()}});
  if (pads > 1 && random.chance(0.5)) {
    if (pushes.size() == 3) pushes.pop_back();
    pushes.push_back({{0, 1}, {depth(), depth()}});
  }
  return pushes;
}

}  // namespace tissued::study
