#include "core/modal_basis.hpp"

#include <Spectra/SymEigsSolver.h>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace tissued::core {

namespace {

// x -> M^1/2 L^-1 M^1/2 x, whose largest eigenvalues are 1 / lambda of the softest modes.
class ComplianceOperator {
 public:
  using Scalar = double;
  ComplianceOperator(const SparseCholesky& factor, const Eigen::VectorXd& root_masses)
      : factor_(factor), root_masses_(root_masses) {}
  Eigen::Index rows() const { return root_masses_.size(); }
  Eigen::Index cols() const { return root_masses_.size(); }
  void perform_op(const double* in, double* out) const {
    const Eigen::Map<const Eigen::VectorXd> x(in, rows());
    Eigen::Map<Eigen::VectorXd>(out, rows()) =
        root_masses_.cwiseProduct(factor_.solve(root_masses_.cwiseProduct(x)).col(0));
  }

 private:
  const SparseCholesky& factor_;
  const Eigen::VectorXd& root_masses_;
};

}  // namespace

ModalBasis modal_basis(const SparseMatrix& laplacian, const Eigen::VectorXd& masses, const std::vector<int>& free_nodes,
                       int modes) {
  const int free = static_cast<int>(free_nodes.size());
  const SparseMatrix lower = restrict_lower(laplacian, free_nodes);
  Eigen::VectorXd root_masses(free);
  for (int i = 0; i < free; ++i) root_masses[i] = std::sqrt(masses[free_nodes[i]]);
  ModalBasis basis;
  Eigen::MatrixXd vectors;
  if (modes <= 0 || modes >= free) {
    const Eigen::VectorXd inverse = root_masses.cwiseInverse();
    Eigen::MatrixXd dense = inverse.asDiagonal() * Eigen::MatrixXd(lower) * inverse.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(dense);  // reads the lower triangle
    basis.lambda = solver.eigenvalues();
    vectors = solver.eigenvectors();
    basis.complete = true;
  } else {
    const SparseCholesky factor(lower);
    ComplianceOperator op(factor, root_masses);
    Spectra::SymEigsSolver<ComplianceOperator> solver(op, modes, std::min(2 * modes + 20, free));
    solver.init();
    const auto found = solver.compute(Spectra::SortRule::LargestAlge, 1000, 1e-10, Spectra::SortRule::LargestAlge);
    if (solver.info() != Spectra::CompInfo::Successful || found < modes)
      throw ModelError("the modal basis of the filter did not converge: ask for fewer filter.modes");
    basis.lambda = solver.eigenvalues().cwiseInverse();
    vectors = solver.eigenvectors();
  }
  basis.shapes = root_masses.cwiseInverse().asDiagonal() * vectors;
  return basis;
}

}  // namespace tissued::core
