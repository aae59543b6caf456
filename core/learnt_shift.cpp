#include "core/learnt_shift.hpp"

#include <algorithm>

#include "core/dense_kernels.hpp"
#include "core/neo_hookean.hpp"

namespace tissued::core {

namespace {

constexpr std::size_t kParts = 8;  // frames, of large meshes
constexpr std::size_t kFewestDomains = 500, kFewestRows = 2000;

std::size_t share_of(std::size_t all, std::size_t fewest) { return std::max(fewest, all / kParts + 1); }

}  // namespace

LearntShift::LearntShift(const Model& model)
    : slot_of_(model.domains().size()),
      domains_per_frame_(share_of(model.domains().size(), kFewestDomains)),
      rows_per_frame_(share_of(3 * static_cast<std::size_t>(model.system().free_count()), kFewestRows)),
      force_(3 * static_cast<std::size_t>(model.system().free_count())),
      answer_(3 * (model.marker_points().size() + model.target_points().size() + model.pad_nodes().size())),
      at_marker_(model.marker_points().size()) {
  const std::vector<int>& domain_of = model.blocks().domain;
  for (std::size_t slot = 0; slot < domain_of.size(); ++slot)
    if (domain_of[slot] >= 0) slot_of_[static_cast<std::size_t>(domain_of[slot])] = slot;
  reset();
}

void LearntShift::reset() {
  next_domain_ = next_row_ = 0;
  std::fill(at_marker_.begin(), at_marker_.end(), Vec3::Zero());
}

void LearntShift::advance(const Model& model, const RestCompliance& compliance, const AdmmState& state) {
  const std::size_t domains = slot_of_.size();
  if (next_domain_ == 0) std::fill(force_.begin(), force_.end(), 0.0);
  if (next_domain_ < domains) {
    add_forces(model, state, std::min(next_domain_ + domains_per_frame_, domains));
    return;
  }
  if (next_row_ == 0) std::fill(answer_.begin(), answer_.end(), 0.0);
  add_answers(compliance, std::min(next_row_ + rows_per_frame_, force_.size()));
  if (next_row_ < force_.size()) return;
  for (std::size_t i = 0; i < at_marker_.size(); ++i)
    at_marker_[i] = -Vec3(answer_[3 * i], answer_[3 * i + 1], answer_[3 * i + 2]);
  next_domain_ = next_row_ = 0;
}

void LearntShift::add_forces(const Model& model, const AdmmState& state, std::size_t end) {
  for (; next_domain_ < end; ++next_domain_) {
    const StrainDomain& domain = model.domains()[next_domain_];
    const std::size_t slot = slot_of_[next_domain_];
    const double more = state.domains[slot / kLanes].factor[slot % kLanes] - 1.0;
    if (more == 0.0) continue;
    Mat3 f = Mat3::Zero();
    for (std::size_t a = 0; a < domain.nodes.size(); ++a)
      f += state.x.row(domain.nodes[a]).head<3>().transpose() * domain.gradients[a].transpose();
    if (!(f.determinant() > 0.0)) continue;
    const Mat3 stress = more * domain.volume * first_piola(domain.shear_modulus, domain.bulk_modulus, f);
    for (std::size_t a = 0; a < domain.nodes.size(); ++a) {
      const int free = model.system().free_index()[domain.nodes[a]];
      if (free < 0) continue;
      const Vec3 force = stress * domain.gradients[a];
      for (int axis = 0; axis < 3; ++axis) force_[static_cast<std::size_t>(3 * free + axis)] += force[axis];
    }
  }
}

void LearntShift::add_answers(const RestCompliance& compliance, std::size_t end) {
  const RowMatrix& columns = compliance.columns();
  add_product(1, static_cast<int>(end - next_row_), static_cast<int>(columns.cols()), force_.data() + next_row_,
              columns.row(static_cast<Eigen::Index>(next_row_)).data(), answer_.data());
  next_row_ = end;
}

}  // namespace tissued::core
