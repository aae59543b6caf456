#include "core/stiffness_field.hpp"

#include <cmath>

namespace tissued::core {

RowMatrix stiffness_field(const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>& points, double sd,
                          double length, int most) {
  constexpr double kUnexplained = 0.1;
  const Eigen::Index n = points.rows();
  Eigen::MatrixXd columns(n, std::min<Eigen::Index>(most, n));
  Eigen::VectorXd left = Eigen::VectorXd::Constant(n, sd * sd);
  Eigen::Index rank = 0;
  while (rank < columns.cols()) {
    Eigen::Index pivot;
    const double largest = left.maxCoeff(&pivot);
    if (largest <= kUnexplained * sd * sd) break;
    const Eigen::VectorXd square = (points.rowwise() - points.row(pivot)).rowwise().squaredNorm();
    Eigen::VectorXd column = sd * sd * (square.array() / (-2.0 * length * length)).exp().matrix();
    column -= columns.leftCols(rank) * columns.row(pivot).head(rank).transpose();
    columns.col(rank) = column / std::sqrt(largest);
    left -= columns.col(rank).cwiseAbs2();
    ++rank;
  }
  return columns.leftCols(rank);
}

}  // namespace tissued::core
