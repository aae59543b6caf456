// Springs spread over facets: the traction K u, u how far a point of the surface is from where a rigid support would
// have it, the rest or a pad's pose. So supports and pads can hold firmly, loosely, or in some directions only.
#pragma once

#include "core/effects/effect_numbers.hpp"
#include "core/effects/facet.hpp"

namespace tissued::core {

inline constexpr double kFirm = 1e6;     // kPa/mm: a traction of 1 kPa moves it by a nanometre
inline constexpr double kHalfway = 0.5;  // kPa/mm, of the order of soft tissue itself: what is left halfway to loose

// kPa/mm: firm at 0, kHalfway (1 - l) / l in between, none at 1. Its compliance grows evenly from 0 on, as does what
// can be seen of it.
constexpr double loosened(double looseness) {
  return kFirm * (1.0 - looseness) / (1.0 - looseness + looseness * kFirm / kHalfway);
}

class FacetSprings : public WithNumbers<FemTerm> {
 public:
  // pads: beside facets; the pad that a facet follows, absent: no springs. -1: it is held where it is at rest.
  FacetSprings(const Effect& effect, const Scene& scene, const FemMesh& mesh, std::vector<Facet> facets,
               std::vector<int> pads);

  int entity_count() const final { return static_cast<int>(facets_.size()); }
  int nodes_per_entity() const final { return facets_.empty() ? 3 : facets_.front().count; }
  std::span<const int> nodes_of_entity(int entity) const final {
    return {facets_[entity].nodes.data(), static_cast<std::size_t>(facets_[entity].count)};
  }
  void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const final;
  void add_pad_forces(const TermInput& input, std::span<Vec3> forces) const final;
  void add_pad_slope(int pad, const Vec3& axis, const TermInput& input, Eigen::VectorXd& slope) const final;

 protected:
  // kPa/mm, symmetric, at rest (it turns with the pad), at a point of a facet.
  virtual Mat3 stiffness(const Facet& facet, int pad, const Vec3& rest) const = 0;
  // To be called once a derived class is complete; again with every change of a number.
  void changed() final;

 private:
  // What springs of one facet do now.
  struct Support {
    Mat3 rotation;
    Vec3 shift;  // a rest position X is held at rotation X + shift
    bool active;
  };
  Support support_of(int entity, const TermInput& input) const;
  Vec3 away(int entity, int point, const Support& support, const double* x) const;  // mm
  Mat3 weighted(int entity, int point, const Support& support) const;               // mN/mm

  const FemMesh* mesh_;
  std::vector<Vec3> centers_;  // of the pads at rest
  std::vector<Facet> facets_;
  std::vector<int> pads_;
  std::vector<Mat3> stiffness_;  // (facets x points)
};

// k_across n n^T + k_along (1 - n n^T).
Mat3 plate_springs(const Vec3& normal, double across, double along);

}  // namespace tissued::core
