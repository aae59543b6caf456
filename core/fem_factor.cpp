#include "core/fem_factor.hpp"

#include <cholmod.h>
#include <omp.h>

#include <cmath>

// OpenBLAS, where that is the BLAS below CHOLMOD; not there in others.
extern "C" void openblas_set_num_threads(int) __attribute__((weak));

namespace tissued::core {

namespace {

// One thread while CHOLMOD works: OpenBLAS's bits depend on how many it has, and CHOLMOD's own loops over threads cost
// more than they bring on panels of this size.
class OneThread {
 public:
  OneThread() : levels_(omp_get_max_active_levels()) {
    omp_set_max_active_levels(0);
    if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
  }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;
  ~OneThread() { omp_set_max_active_levels(levels_); }

 private:
  int levels_;
};

}  // namespace

struct FemFactor::Parts {
  mutable cholmod_common common;
  cholmod_factor* factor = nullptr;
  bool ready = false;
  std::vector<int> node;           // free nodes, ascending
  std::vector<int> column, row;    // the reduced matrix
  std::vector<int> from;           // (entries) of the pattern
  std::vector<double> values;      // (entries)
  std::vector<std::uint8_t> held;  // (nodes), as last factored

  Parts() {
    cholmod_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    common.print = 0;
  }
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  ~Parts() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }

  cholmod_sparse view() {
    cholmod_sparse a{};
    a.nrow = a.ncol = column.size() - 1;
    a.nzmax = row.size();
    a.p = column.data();
    a.i = row.data();
    a.x = values.data();
    a.stype = -1;
    a.itype = CHOLMOD_INT;
    a.xtype = CHOLMOD_REAL;
    a.dtype = CHOLMOD_DOUBLE;
    a.sorted = 1;
    a.packed = 1;
    return a;
  }
};

FemFactor::FemFactor(const FemPattern& pattern, const std::vector<std::uint8_t>& excluded)
    : parts_(std::make_unique<Parts>()) {
  Parts& p = *parts_;
  std::vector<int> reduced(static_cast<std::size_t>(pattern.node_count), -1);
  for (int i = 0; i < pattern.node_count; ++i) {
    if (excluded[i]) continue;
    reduced[i] = static_cast<int>(p.node.size());
    p.node.push_back(i);
  }
  if (p.node.empty()) throw ModelError("no node is free: the whole body is held");
  p.column.push_back(0);
  for (int j : p.node) {
    for (int c = 0; c < 3; ++c) {
      for (int k = pattern.column[3 * j + c]; k < pattern.column[3 * j + c + 1]; ++k) {
        const int node = pattern.row[k] / 3;
        if (reduced[node] < 0) continue;
        p.row.push_back(3 * reduced[node] + pattern.row[k] % 3);
        p.from.push_back(k);
      }
      p.column.push_back(static_cast<int>(p.row.size()));
    }
  }
  p.values.assign(p.row.size(), 1.0);
  cholmod_sparse a = p.view();
  p.factor = cholmod_analyze(&a, &p.common);
  if (p.factor == nullptr) throw ModelError("CHOLMOD cannot analyse the tangent: out of memory?");
}

FemFactor::~FemFactor() = default;
FemFactor::FemFactor(FemFactor&&) noexcept = default;
FemFactor& FemFactor::operator=(FemFactor&&) noexcept = default;

bool FemFactor::factorize(const std::vector<double>& values, const std::vector<std::uint8_t>& held, double shift) {
  Parts& p = *parts_;
  p.ready = false;
  p.held = held;
  double mean = 0.0;
  const int size = rows();
  for (int j = 0; j < size; ++j) mean += values[p.from[p.column[j]]] / size;
  if (!std::isfinite(mean)) return false;
  for (int j = 0; j < size; ++j) {
    const bool column_held = held[p.node[j / 3]] != 0;
    for (int k = p.column[j]; k < p.column[j + 1]; ++k) {
      const bool diagonal = k == p.column[j];  // columns are sorted and lower
      if (column_held || held[p.node[p.row[k] / 3]] != 0)
        p.values[k] = diagonal ? mean : 0.0;
      else
        p.values[k] = values[p.from[k]] + (diagonal ? shift * mean : 0.0);
    }
  }
  cholmod_sparse a = p.view();
  const OneThread one;
  cholmod_factorize(&a, p.factor, &p.common);
  p.ready = p.common.status == CHOLMOD_OK && p.factor->minor == p.factor->n;
  return p.ready;
}

bool FemFactor::ready() const { return parts_->ready; }

Eigen::MatrixXd FemFactor::solve(const Eigen::MatrixXd& b) const {
  const Parts& p = *parts_;
  Eigen::MatrixXd right(rows(), b.cols());
  for (std::size_t k = 0; k < p.node.size(); ++k) {
    auto rows = right.middleRows<3>(3 * static_cast<Eigen::Index>(k));
    if (p.held[p.node[k]])
      rows.setZero();
    else
      rows = b.middleRows<3>(3 * p.node[k]);
  }
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(right.rows());
  view.ncol = static_cast<std::size_t>(right.cols());
  view.nzmax = static_cast<std::size_t>(right.size());
  view.d = view.nrow;
  view.x = right.data();
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  const OneThread one;
  cholmod_dense* answer = cholmod_solve(CHOLMOD_A, p.factor, &view, &p.common);
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(b.rows(), b.cols());
  const Eigen::Map<Eigen::MatrixXd> solved(static_cast<double*>(answer->x), right.rows(), right.cols());
  for (std::size_t k = 0; k < p.node.size(); ++k)
    x.middleRows<3>(3 * p.node[k]) = solved.middleRows<3>(3 * static_cast<Eigen::Index>(k));
  cholmod_free_dense(&answer, &p.common);
  return x;
}

int FemFactor::rows() const { return static_cast<int>(parts_->column.size()) - 1; }
double FemFactor::entries() const { return parts_->common.lnz; }
double FemFactor::flops() const { return parts_->common.fl; }

}  // namespace tissued::core
