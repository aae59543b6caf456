// The rotation that a 3 x 3 matrix is nearest to.
#pragma once

#include <Eigen/Geometry>

#include "core/types.hpp"

namespace tissued::core {

// Turns `rotation` into the proper rotation R that maximises tr(R^T a), the orthogonal factor of a's polar
// decomposition where det a > 0. Newton's method on the group of rotations (the task and the warm start of Müller et
// al., A Robust Method to Extract the Rotational Part of Deformations, 2016; theirs converges linearly): the closer
// `rotation` is already, the cheaper. What `a` leaves open, about the line of a rank of one say, stays as it is in
// `rotation`. Falls back on a singular value decomposition where Newton does not climb. Allocates nothing; an `a` that
// is not finite leaves a rotation that is not.
void polar_rotation(const Mat3& a, Eigen::Quaterniond& rotation);

}  // namespace tissued::core
