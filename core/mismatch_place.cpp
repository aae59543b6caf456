#include "core/mismatch_place.hpp"

#include <algorithm>

namespace tissued::core {

namespace {

constexpr std::size_t kFewestNodes = 200, kParts = 16;
constexpr double kForgetting = 0.2;  // share of the older evidence, with each new one
// Of the largest response of any node: what markers hardly feel is not found by them.
constexpr double kFaint = 0.02;

}  // namespace

MismatchPlace::MismatchPlace(const Model& model) : misfit_(model.marker_points().size(), Vec3::Zero()) {
  for (int node : model.system().free_nodes()) nodes_.push_back(model.rest().row(node).head<3>().transpose());
  scores_.resize(nodes_.size());
  used_.reserve(misfit_.size());
  per_frame_ = std::max(kFewestNodes, nodes_.size() / kParts + 1);
  reset();
}

void MismatchPlace::reset() {
  std::fill(scores_.begin(), scores_.end(), 0.0);
  best_ = -1;
  next_ = nodes_.size();
}

void MismatchPlace::add(std::span<const Vec3> misfit, std::span<const int> used, double weight) {
  if (next_ < nodes_.size()) return;
  std::copy(misfit.begin(), misfit.end(), misfit_.begin());
  used_.assign(used.begin(), used.end());
  square_ = 0.0;
  for (int marker : used_) square_ += misfit_[static_cast<std::size_t>(marker)].squaredNorm();
  if (square_ == 0.0) return;
  weight_ = weight;
  next_ = 0;
}

// Of the misfit's square, by the best force at this node along each axis: the axes of a force are nearly orthogonal in
// what markers see of them, and are taken for it.
double MismatchPlace::explained(const RowMatrix& columns, std::size_t node) const {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double* row = columns.row(static_cast<Eigen::Index>(3 * node) + axis).data();
    double along = 0.0, norm = 0.0;
    for (int marker : used_) {
      const Vec3& m = misfit_[static_cast<std::size_t>(marker)];
      for (int k = 0; k < 3; ++k) {
        along += row[3 * marker + k] * m[k];
        norm += row[3 * marker + k] * row[3 * marker + k];
      }
    }
    if (norm > 0.0) sum += along * along / (norm + kFaint * kFaint * stiffest_);
  }
  return std::min(1.0, sum / square_);
}

void MismatchPlace::advance(const RestCompliance& compliance) {
  if (next_ >= nodes_.size()) return;
  const RowMatrix& columns = compliance.columns();
  if (next_ == 0) {
    stiffest_ = 0.0;
    for (int marker : used_)
      stiffest_ = std::max(stiffest_, columns.middleCols<3>(3 * marker).rowwise().squaredNorm().maxCoeff());
    stiffest_ *= static_cast<double>(used_.size());
  }
  for (const std::size_t end = std::min(next_ + per_frame_, nodes_.size()); next_ < end; ++next_)
    scores_[next_] = (1.0 - kForgetting) * scores_[next_] + weight_ * explained(columns, next_);
  if (next_ == nodes_.size())
    best_ = static_cast<int>(std::max_element(scores_.begin(), scores_.end()) - scores_.begin());
}

}  // namespace tissued::core
