#include "core/particle_contact.hpp"

#include <algorithm>

namespace tissued::core {

namespace {

// What the cone lets be taken back of a slide. Both mm.
Vec3 held_back(const Vec3& slide, double limit) {
  const double length = slide.norm();
  return length > limit ? Vec3(slide * (limit / length)) : slide;
}

}  // namespace

ParticleContact::ParticleContact(const ProbeShape& shape, double distance, double reach, double friction,
                                 std::size_t particles)
    : shape_(shape), distance_(distance), reach_(reach), friction_(friction) {
  found_.reserve(particles);
}

void ParticleContact::find(const PoseChange& motion, std::span<const double> mobility, const NodeField& x) {
  found_.clear();
  const RigidTransform probe_T_tissue = motion.end.inverse();
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    if (mobility[static_cast<std::size_t>(i)] == 0.0) continue;
    const Vec3 local = probe_T_tissue(x.row(i).head<3>().transpose());
    if (signed_distance(shape_, local).distance < distance_ + reach_) found_.push_back(static_cast<int>(i));
  }
}

int ParticleContact::resolve(const PoseChange& motion, const NodeField& start, NodeField& x) const {
  const RigidTransform probe_T_tissue = motion.end.inverse(), carried = motion.end * motion.begin.inverse();
  int pushes = 0;
  for (int i : found_) {
    const Vec3 p = x.row(i).head<3>().transpose();
    const SignedDistance outside = signed_distance(shape_, probe_T_tissue(p));
    const double push = distance_ - outside.distance;
    if (!(push > 0.0)) continue;
    ++pushes;
    const Vec3 normal = motion.end.rotation * outside.normal;
    const Vec3 pushed = p + push * normal;
    // From where the probe would have taken it along to.
    const Vec3 moved = pushed - carried(start.row(i).head<3>().transpose());
    const Vec3 corrected = pushed - held_back(moved - normal.dot(moved) * normal, friction_ * push);
    x.row(i).head<3>() = corrected.transpose();
  }
  return pushes;
}

double ParticleContact::penetration(const PoseChange& motion, const NodeField& x) const {
  const RigidTransform probe_T_tissue = motion.end.inverse();
  double deepest = 0.0;
  for (int i : found_)
    deepest = std::max(deepest, -signed_distance(shape_, probe_T_tissue(x.row(i).head<3>().transpose())).distance);
  return deepest;
}

}  // namespace tissued::core
