// Smoothed gradients against their definition, averaged here from plain element gradients, and against the patch test.
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "core/neo_hookean.hpp"
#include "core/static_solve.hpp"
#include "tests/core/test_bodies.hpp"

using namespace tissued::core;
using namespace tissued::core::testing;

namespace {

Mat3 element_gradient(const TetMesh& mesh, const Tet& tet, const NodeField& x) {
  Mat3 rest, now;
  for (int a = 0; a < 3; ++a) {
    rest.col(a) = mesh.node(tet[a + 1]) - mesh.node(tet[0]);
    now.col(a) = (x.row(tet[a + 1]) - x.row(tet[0])).head<3>().transpose();
  }
  return now * rest.inverse();
}

Mat3 domain_gradient(const StrainDomain& domain, const NodeField& x) {
  Mat3 f = Mat3::Zero();
  for (std::size_t a = 0; a < domain.nodes.size(); ++a)
    f += x.row(domain.nodes[a]).head<3>().transpose() * domain.gradients[a].transpose();
  return f;
}

NodeField shaken(const TetMesh& mesh, double size, std::mt19937& generator) {
  NodeField x = NodeField::Zero(mesh.node_count(), 4);
  for (int i = 0; i < mesh.node_count(); ++i)
    x.row(i).head<3>() = (mesh.node(i) + size * random_vector(generator)).transpose();
  return x;
}

struct Averages {
  std::map<std::set<int>, Mat3> weighted;  // of an edge (two nodes) or a node: volume times gradient
  std::map<std::set<int>, double> volume;

  void add(const std::set<int>& key, double share, const Mat3& f) {
    weighted.try_emplace(key, Mat3::Zero()).first->second += share * f;
    volume[key] += share;
  }
};

// Energy (11) of smoothed gradients by its definition, mN mm.
double smoothed_energy(const TetMesh& mesh, const Material& material, double shear_at_nodes, const NodeField& x) {
  Averages averages;
  for (const Tet& tet : mesh.tets) {
    const Mat3 f = element_gradient(mesh, tet, x);
    const double volume = signed_volume(mesh, tet);
    for (int a = 0; a < 4; ++a) {
      averages.add({tet[a]}, volume / 4.0, f);
      for (int b = 0; b < a; ++b) averages.add({tet[a], tet[b]}, volume / 6.0, f);
    }
  }
  double energy = 0.0;
  for (const auto& [key, weighted] : averages.weighted) {
    const double volume = averages.volume[key];
    const Mat3 f = weighted / volume;
    const double j = f.determinant(),
                 mu = (key.size() == 1 ? shear_at_nodes : 1.0 - shear_at_nodes) * material.shear_modulus();
    energy += volume * 0.5 * mu * (f.squaredNorm() / std::cbrt(j * j) - 3.0);
    if (key.size() == 1) energy += volume * 0.5 * material.bulk_modulus() * (j - 1.0) * (j - 1.0);
  }
  return energy;
}

double domain_energy(const std::vector<StrainDomain>& domains, const NodeField& x) {
  double energy = 0.0;
  for (const StrainDomain& domain : domains) {
    const Mat3 f = domain_gradient(domain, x);
    const double j = f.determinant();
    energy += domain.volume * 0.5 *
              (domain.shear_modulus * (f.squaredNorm() / std::cbrt(j * j) - 3.0) +
               domain.bulk_modulus * (j - 1.0) * (j - 1.0));
  }
  return energy;
}

}  // namespace

TEST_CASE("domains share out the body's volume and see linear fields exactly", "[strain_domains]") {
  const Element element = GENERATE(Element::p1, Element::smoothed);
  const Scene scene = box_scene({4, 3, 2, 7.0});
  const double body = 24 * 7.0 * 7.0 * 7.0;
  const auto domains = strain_domains(scene.mesh, scene.material, element);
  std::mt19937 generator(17);
  const Mat3 slope = Mat3::Identity() + 0.3 * random_matrix(generator);
  NodeField x = NodeField::Zero(scene.mesh.node_count(), 4);
  x.leftCols<3>() = scene.mesh.rest * slope.transpose();
  double shear = 0.0, bulk = 0.0;
  for (const StrainDomain& domain : domains) {
    CHECK((domain_gradient(domain, x) - slope).norm() < 1e-12);
    CHECK(std::is_sorted(domain.nodes.begin(), domain.nodes.end()));
    Vec3 sum = Vec3::Zero();
    for (const Vec3& gradient : domain.gradients) sum += gradient;
    CHECK(sum.norm() < 1e-14);
    shear += domain.volume * domain.shear_modulus;
    bulk += domain.volume * domain.bulk_modulus;
  }
  CHECK(shear == Approx(body * scene.material.shear_modulus()));
  CHECK(bulk == Approx(body * scene.material.bulk_modulus()));
}

TEST_CASE("smoothed energy is the energy of averaged gradients", "[strain_domains]") {
  const Scene scene = box_scene({3, 3, 2, 6.0});
  std::mt19937 generator(23);
  const auto domains = strain_domains(scene.mesh, scene.material, Element::smoothed);
  for (int draw = 0; draw < 5; ++draw) {
    const NodeField x = shaken(scene.mesh, 0.4, generator);
    CHECK(domain_energy(domains, x) == Approx(smoothed_energy(scene.mesh, scene.material, 0.1, x)).epsilon(1e-12));
  }
}

TEST_CASE("a smoothed static answer is a minimum of that energy", "[strain_domains]") {
  const Scene scene = box_scene({4, 3, 3, 6.0});
  std::vector<PadInput> pads(scene.pads.size());
  pads[0].kind = PadInput::Kind::pose;
  pads[0].center = scene.pads[0].center + 2.5 * scene.pads[0].direction;
  StaticOptions options;
  options.tolerance = 1e-8;
  options.threads = 1;
  const StaticSolution solution = solve_static(scene, pads, options);
  REQUIRE(solution.converged);
  std::set<int> held;
  for (const char* name : {"base", scene.pads[0].surface.c_str()})
    for (int node : nodes_of(*scene.mesh.find_surface(name))) held.insert(node);
  const double h = 1e-4;
  Vec3 pad_force = Vec3::Zero();
  const std::vector<int> pad_nodes = nodes_of(*scene.mesh.find_surface(scene.pads[0].surface));
  for (int node = 0; node < scene.mesh.node_count(); ++node) {
    for (int axis = 0; axis < 3; ++axis) {
      NodeField plus = solution.positions, minus = solution.positions;
      plus(node, axis) += h;
      minus(node, axis) -= h;
      const double slope = (smoothed_energy(scene.mesh, scene.material, 0.1, plus) -
                            smoothed_energy(scene.mesh, scene.material, 0.1, minus)) /
                           (2.0 * h);  // mN
      if (held.count(node) == 0) CHECK(std::abs(slope) < 1e-3);
      if (std::binary_search(pad_nodes.begin(), pad_nodes.end(), node)) pad_force[axis] += slope / 1e3;
    }
  }
  CHECK((solution.pad_forces[0] - pad_force).norm() < 1e-5 + 1e-4 * pad_force.norm());
}

TEST_CASE("a body under uniform strain is in equilibrium whatever the element", "[strain_domains]") {
  const Element element = GENERATE(Element::p1, Element::smoothed);
  const Scene scene = box_scene({4, 4, 3, 5.0});
  const auto domains = strain_domains(scene.mesh, scene.material, element);
  const Mat3 f = (Mat3() << 1.1, 0.2, 0.0, -0.1, 0.9, 0.1, 0.05, 0.0, 1.05).finished();
  std::set<int> skin;
  for (const Triangle& facet : boundary_of(scene.mesh)) skin.insert(facet.begin(), facet.end());
  NodeField force = NodeField::Zero(scene.mesh.node_count(), 4);
  for (const StrainDomain& domain : domains) {
    const Mat3 stress = domain.volume * first_piola(domain.shear_modulus, domain.bulk_modulus, f);
    for (std::size_t a = 0; a < domain.nodes.size(); ++a)
      force.row(domain.nodes[a]).head<3>() += (stress * domain.gradients[a]).transpose();
  }
  for (int node = 0; node < scene.mesh.node_count(); ++node)
    if (skin.count(node) == 0) CHECK(force.row(node).norm() < 1e-10);
}
