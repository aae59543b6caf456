// A smooth random field over the body in a few coefficients: what is not known of its stiffness.
#pragma once

#include <Eigen/Core>

#include "core/modal_covariance.hpp"

namespace tissued::core {

// Rows (points x r): the field at a point is row . c with c ~ N(0, I), a Gaussian process of standard deviation sd and
// covariance sd^2 exp(-d^2 / (2 length^2)). points: (n x 3) mm; length: mm. As many columns as leave no point with more
// than a tenth of its variance unexplained, `most` at most (pivoted Cholesky).
RowMatrix stiffness_field(const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>& points, double sd,
                          double length, int most);

}  // namespace tissued::core
