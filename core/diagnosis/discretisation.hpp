// What the size of the elements costs: answers along a push by elements of half the size, against the session's own.
#pragma once

#include "core/diagnosis/path_solver.hpp"

namespace tissued::core {

// Finer elements take too long beyond.
inline constexpr int kMostRefinedTets = 4000;

// By the share of the push, 0 to 1.
struct FinerAnswer {
  bool solved = false;
  Eigen::RowVectorXd slope, bend;                // (channels) of the difference in mm; zero for forces
  Eigen::RowVectorXd force_ratio, force_change;  // (pads) finer by own at no push, and what that changes by to a whole

  Eigen::RowVectorXd difference(double share) const { return share * (slope + share * bend); }
  Eigen::RowVectorXd force_factor(double share) const { return force_ratio + share * force_change; }
};

// The way from rest to these pads by quadratic elements on scene's mesh and on its refinement. Solved at two parts of
// it: near its end finer elements take most of the time, for hardly more than a parabola says.
FinerAnswer finer_answer(const Scene& scene, std::span<const PadInput> pads);

}  // namespace tissued::core
