#include "core/cholmod_factor.hpp"

#include <omp.h>

#include <cstdlib>
#include <mutex>
#include <string_view>

// OpenBLAS, where that is the BLAS below CHOLMOD; not there in others.
extern "C" {
void openblas_set_num_threads(int) __attribute__((weak));
char* openblas_get_corename() __attribute__((weak));
void gotoblas_dynamic_quit() __attribute__((weak));
void gotoblas_dynamic_init() __attribute__((weak));
}

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

// OpenBLAS knows processors by their number, and takes one that is newer than itself for the oldest. Before main, while
// nobody else can be computing or reading the environment.
struct KernelChoice {
  KernelChoice() {
#if defined(__x86_64__)
    constexpr const char* kChoice = "OPENBLAS_CORETYPE";
    if (openblas_get_corename == nullptr || gotoblas_dynamic_quit == nullptr || gotoblas_dynamic_init == nullptr)
      return;
    if (std::getenv(kChoice) != nullptr || std::string_view(openblas_get_corename()) != "Prescott") return;
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return;
    const bool has_avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                            __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
    setenv(kChoice, has_avx512 ? "SkylakeX" : "Haswell", 1);
    gotoblas_dynamic_quit();
    gotoblas_dynamic_init();
#endif
  }
};
const KernelChoice kKernelChoice;

}  // namespace

cholmod_sparse lower_view(std::size_t size, std::size_t entries, const int* columns, const int* rows,
                          const double* values) {
  cholmod_sparse a{};
  a.nrow = a.ncol = size;
  a.nzmax = entries;
  a.p = const_cast<int*>(columns);
  a.i = const_cast<int*>(rows);
  a.x = const_cast<double*>(values);
  a.stype = -1;
  a.itype = CHOLMOD_INT;
  a.xtype = CHOLMOD_REAL;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
  return a;
}

CholmodFactor::CholmodFactor() {
  cholmod_start(&common);
  common.supernodal = CHOLMOD_SUPERNODAL;
  common.final_ll = 1;
  common.print = 0;
}

CholmodFactor::~CholmodFactor() {
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
}

bool CholmodFactor::analyze(cholmod_sparse matrix) {
  // METIS, which orders, sets the process's SIGTERM handler and puts back the one that it found: two at once would
  // leave its own behind.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  factor = cholmod_analyze(&matrix, &common);
  return factor != nullptr;
}

bool CholmodFactor::factorize(cholmod_sparse matrix) {
  const OneThread one;
  cholmod_factorize(&matrix, factor, &common);
  return common.status == CHOLMOD_OK && factor->minor == factor->n;
}

Eigen::MatrixXd CholmodFactor::solve(const Eigen::MatrixXd& b) const {
  cholmod_dense view{};
  view.nrow = static_cast<std::size_t>(b.rows());
  view.ncol = static_cast<std::size_t>(b.cols());
  view.nzmax = static_cast<std::size_t>(b.size());
  view.d = view.nrow;
  view.x = const_cast<double*>(b.data());
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  const OneThread one;
  cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor, &view, &common);
  Eigen::MatrixXd x = Eigen::Map<Eigen::MatrixXd>(static_cast<double*>(solution->x), b.rows(), b.cols());
  cholmod_free_dense(&solution, &common);
  return x;
}

}  // namespace tissued::core
