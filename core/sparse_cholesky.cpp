#include "core/sparse_cholesky.hpp"

#include <algorithm>

#include "core/cholmod_factor.hpp"
#include "core/types.hpp"

namespace tissued::core {

struct SparseCholesky::Factor {
  CholmodFactor cholmod;
  std::vector<int> order;
  std::int64_t entries = 0;
  SupernodalPanels panels;
};

namespace {

SupernodalPanels repack(const cholmod_factor& factor) {
  SupernodalPanels out;
  out.size = static_cast<int>(factor.n);
  const auto* super = static_cast<const int*>(factor.super);
  const auto* pi = static_cast<const int*>(factor.pi);
  const auto* px = static_cast<const int*>(factor.px);
  const auto* s = static_cast<const int*>(factor.s);
  const auto* x = static_cast<const double*>(factor.x);
  for (std::size_t k = 0; k < factor.nsuper; ++k) {
    SupernodalPanels::Panel panel{};
    panel.first_column = super[k];
    panel.columns = super[k + 1] - super[k];
    const int total_rows = pi[k + 1] - pi[k];
    panel.rows = total_rows - panel.columns;
    out.largest_panel = std::max(out.largest_panel, panel.columns);
    const auto entry = [&](int row, int column) {
      return x[px[k] + static_cast<std::ptrdiff_t>(column) * total_rows + row];
    };
    panel.triangle = static_cast<std::int64_t>(out.values.size());
    for (int row = 0; row < panel.columns; ++row) {
      for (int column = 0; column < panel.columns; ++column) {
        const double value = column > row ? 0.0 : column == row ? 1.0 / entry(row, row) : entry(row, column);
        out.values.push_back(static_cast<float>(value));
      }
    }
    panel.below = static_cast<std::int64_t>(out.values.size());
    panel.row_list = static_cast<std::int64_t>(out.rows.size());
    for (int row = panel.columns; row < total_rows; ++row) {
      out.rows.push_back(s[pi[k] + row]);
      for (int column = 0; column < panel.columns; ++column)
        out.values.push_back(static_cast<float>(entry(row, column)));
    }
    out.panels.push_back(panel);
  }
  return out;
}

}  // namespace

SparseCholesky::SparseCholesky(const SparseMatrix& lower) : factor_(std::make_unique<Factor>()) {
  CholmodFactor& cholmod = factor_->cholmod;
  const cholmod_sparse matrix =
      lower_view(static_cast<std::size_t>(lower.rows()), static_cast<std::size_t>(lower.nonZeros()),
                 lower.outerIndexPtr(), lower.innerIndexPtr(), lower.valuePtr());
  if (!cholmod.analyze(matrix) || !cholmod.factorize(matrix))
    throw ModelError("the global matrix is not positive definite: is every part of the body held?");
  const auto* order = static_cast<const int*>(cholmod.factor->Perm);
  factor_->order.assign(order, order + cholmod.factor->n);
  factor_->panels = repack(*cholmod.factor);
  factor_->entries = static_cast<std::int64_t>(factor_->panels.values.size());
}

SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

int SparseCholesky::size() const { return static_cast<int>(factor_->cholmod.factor->n); }
const std::vector<int>& SparseCholesky::order() const { return factor_->order; }
std::int64_t SparseCholesky::entries() const { return factor_->entries; }
const SupernodalPanels& SparseCholesky::panels() const { return factor_->panels; }

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& b) const { return factor_->cholmod.solve(b); }

}  // namespace tissued::core
