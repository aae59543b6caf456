#include "core/sparse_cholesky.hpp"

#include <cholmod.h>

#include <algorithm>

#include "core/types.hpp"

namespace tissued::core {

struct SparseCholesky::Factor {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  std::vector<int> order;
  std::int64_t entries = 0;
  SupernodalPanels panels;

  Factor() {
    cholmod_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    common.print = 0;
  }
  Factor(const Factor&) = delete;
  Factor& operator=(const Factor&) = delete;
  ~Factor() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
};

namespace {

cholmod_sparse view_of(const SparseMatrix& lower) {
  cholmod_sparse a{};
  a.nrow = a.ncol = static_cast<std::size_t>(lower.rows());
  a.nzmax = static_cast<std::size_t>(lower.nonZeros());
  a.p = const_cast<int*>(lower.outerIndexPtr());
  a.i = const_cast<int*>(lower.innerIndexPtr());
  a.x = const_cast<double*>(lower.valuePtr());
  a.stype = -1;
  a.itype = CHOLMOD_INT;
  a.xtype = CHOLMOD_REAL;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
  return a;
}

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
  cholmod_sparse a = view_of(lower);
  factor_->factor = cholmod_analyze(&a, &factor_->common);
  if (factor_->factor != nullptr) cholmod_factorize(&a, factor_->factor, &factor_->common);
  if (factor_->factor == nullptr || factor_->common.status != CHOLMOD_OK ||
      factor_->factor->minor < factor_->factor->n) {
    throw ModelError("the global matrix is not positive definite: is every part of the body held?");
  }
  const auto* order = static_cast<const int*>(factor_->factor->Perm);
  factor_->order.assign(order, order + factor_->factor->n);
  factor_->panels = repack(*factor_->factor);
  factor_->entries = static_cast<std::int64_t>(factor_->panels.values.size());
}

SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

int SparseCholesky::size() const { return static_cast<int>(factor_->factor->n); }
const std::vector<int>& SparseCholesky::order() const { return factor_->order; }
std::int64_t SparseCholesky::entries() const { return factor_->entries; }
const SupernodalPanels& SparseCholesky::panels() const { return factor_->panels; }

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& b) const {
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(b.rows());
  view.ncol = static_cast<std::size_t>(b.cols());
  view.nzmax = static_cast<std::size_t>(b.size());
  view.d = view.nrow;
  view.x = const_cast<double*>(b.data());
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor_->factor, &view, &factor_->common);
  Eigen::MatrixXd x = Eigen::Map<Eigen::MatrixXd>(static_cast<double*>(solution->x), b.rows(), b.cols());
  cholmod_free_dense(&solution, &factor_->common);
  return x;
}

}  // namespace tissued::core
