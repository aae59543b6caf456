// What the size of the elements costs: the answer at a load by elements of half the size, against the session's own.
#pragma once

#include "core/diagnosis/path_solver.hpp"

namespace tissued::core {

// Finer elements take too long beyond.
inline constexpr int kMostRefinedTets = 4000;

struct FinerAnswer {
  bool solved = false;
  Eigen::RowVectorXd values;  // (channels)
};

// coarse: where PathSolver (quadratic elements on scene's mesh) found the body under these pads, (3n) mm; finer
// elements start from there.
FinerAnswer finer_answer(const Scene& scene, std::span<const PadInput> pads, const Eigen::VectorXd& coarse);

}  // namespace tissued::core
