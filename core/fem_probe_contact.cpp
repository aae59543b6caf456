#include "core/fem_probe_contact.hpp"

#include <algorithm>
#include <cmath>

#include "core/skin_outline.hpp"

namespace tissued::core {

namespace {

// Of the stiffness of a cube of tissue as large as the node's share of the skin: multipliers settle by about this
// factor in every update, and Newton's method by as much slower.
constexpr double kPenalty = 10.0;

}  // namespace

FemProbeContact::FemProbeContact(const Scene& scene, const FemMesh& mesh, const std::vector<int>& fixed)
    : probes_(scene.probes), motions_(scene.probes.size()) {
  for (const Probe& probe : probes_)
    if (probe.friction > 0.0)
      throw ModelError("probe " + probe.name + " has friction, and the simulator fem has none: set its friction to 0");
  const SkinOutline outline = skin_outline(scene);
  const auto add = [&](int node, const Vec3& normal) {
    if (std::binary_search(fixed.begin(), fixed.end(), node)) return;
    nodes_.push_back(node);
    outwards_.push_back(normal.normalized());
    const double area = normal.norm() / 6.0;  // a third of every facet around it
    stiffness_.push_back(kPenalty * scene.material.youngs_modulus * std::sqrt(area));
  };
  for (const auto& [node, normal] : outline.nodes) add(node, normal);
  if (mesh.element == FemElement::p2)
    for (const auto& [edge, normal] : outline.edges) add(mesh.middle_of(edge[0], edge[1]), normal);
  released_.assign(nodes_.size(), 0);
  multipliers_.assign(probes_.size() * nodes_.size(), 0.0);
  pushes_.assign(multipliers_.size(), Vec3::Zero());
  planes_.resize(multipliers_.size());
  at_.resize(nodes_.size());
}

SignedDistance FemProbeContact::distance(int entity, const Eigen::VectorXd& x) const {
  const RigidTransform& pose = motions_[probe_of(entity)].pose();
  const Vec3 p = x.segment<3>(3 * nodes_[place_of(entity)]);
  SignedDistance found = signed_distance(probes_[probe_of(entity)].shape, pose.inverse()(p));
  found.normal = pose.rotation * found.normal;
  return found;
}

// Tangent planes to the probe at x.
void FemProbeContact::linearise(const Eigen::VectorXd& x) {
  for (int e = 0; e < entity_count(); ++e) {
    if (is_idle(e)) continue;
    const SignedDistance at = distance(e, x);
    planes_[static_cast<std::size_t>(e)] = {at.normal,
                                            at.distance - at.normal.dot(x.segment<3>(3 * nodes_[place_of(e)]))};
  }
}

void FemProbeContact::evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const {
  for (int e = begin; e < end; ++e) {
    const EntityOutput out = cleared(output, e, 1);
    if (is_idle(e)) continue;
    const Plane& plane = planes_[static_cast<std::size_t>(e)];
    const Eigen::Map<const Vec3> x(input.x + 3 * static_cast<std::ptrdiff_t>(nodes_[place_of(e)]));
    const double k = stiffness_[place_of(e)], lambda = multipliers_[static_cast<std::size_t>(e)];
    const double push = std::max(0.0, lambda - k * plane.distance(x));
    if (output.energy != nullptr) output.energy[e] = (push * push - lambda * lambda) / (2.0 * k);
    if (push == 0.0) continue;
    if (out.residual != nullptr) Eigen::Map<Vec3>(out.residual) = -push * plane.normal;
    if (out.tangent != nullptr) Eigen::Map<Mat3>(out.tangent) = k * plane.normal * plane.normal.transpose();
  }
}

void FemProbeContact::lift() {
  for (ProbeMotion& motion : motions_) motion.forget();
  std::fill(multipliers_.begin(), multipliers_.end(), 0.0);
}

double FemProbeContact::follow(std::span<const ProbeInput> inputs, const Eigen::VectorXd& x, double limit) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) at_[i] = x.segment<3>(3 * nodes_[i]);
  double ahead = 0.0;
  for (std::size_t p = 0; p < motions_.size(); ++p)
    ahead = std::max(ahead, motions_[p].follow(probes_[p].shape, inputs[p], at_, outwards_, limit));
  for (int e = 0; e < entity_count(); ++e)
    if (is_idle(e)) multipliers_[static_cast<std::size_t>(e)] = 0.0;
  linearise(x);
  return ahead;
}

void FemProbeContact::release(std::span<const std::uint8_t> held) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) released_[i] = held[static_cast<std::size_t>(nodes_[i])];
}

double FemProbeContact::update(const Eigen::VectorXd& x) {
  double violated = 0.0;
  for (int e = 0; e < entity_count(); ++e) {
    if (is_idle(e)) continue;
    const Plane& plane = planes_[static_cast<std::size_t>(e)];
    const double k = stiffness_[place_of(e)];
    double& lambda = multipliers_[static_cast<std::size_t>(e)];
    const double push = std::max(0.0, lambda - k * plane.distance(x.segment<3>(3 * nodes_[place_of(e)])));
    violated = std::max(violated, std::abs(push - lambda) / k);
    if (push > 0.0) violated = std::max(violated, std::abs(distance(e, x).distance));
    lambda = push;
    pushes_[static_cast<std::size_t>(e)] = plane.normal;
  }
  linearise(x);
  return violated;
}

int FemProbeContact::pressed() const {
  return static_cast<int>(
      std::count_if(multipliers_.begin(), multipliers_.end(), [](double lambda) { return lambda > 0.0; }));
}

Vec3 FemProbeContact::force(int probe) const {
  Vec3 sum = Vec3::Zero();
  const std::size_t first = static_cast<std::size_t>(probe) * nodes_.size();
  for (std::size_t e = first; e < first + nodes_.size(); ++e) sum += multipliers_[e] * pushes_[e];
  return sum / kMillinewtonPerNewton;
}

double FemProbeContact::penetration(const Eigen::VectorXd& x) const {
  double deepest = 0.0;
  for (int e = 0; e < entity_count(); ++e)
    if (!is_idle(e)) deepest = std::max(deepest, -distance(e, x).distance);
  return deepest;
}

}  // namespace tissued::core
