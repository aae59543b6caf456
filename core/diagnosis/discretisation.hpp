// What the size of the elements costs: answers along a push by elements of half the size, against the session's own.
#pragma once

#include <atomic>
#include <optional>

#include "core/diagnosis/fit.hpp"

namespace tissued::core {

// Finer elements take too long beyond.
inline constexpr int kMostRefinedTets = 4000;

// By the share of the push, 0 to 1: polynomials of as many terms as there were answers.
struct FinerAnswer {
  double reached = 0.0;   // share of the push that finer elements were solved for; 0: nothing is known
  RowMatrix differs;      // (terms x channels) of the difference, mm, from its first power on; zero for forces
  RowMatrix force_ratio;  // (terms x pads) of finer by own, from its constant on

  bool solved() const { return reached > 0.0; }
  Eigen::RowVectorXd difference(double share) const { return share * powers(share) * differs; }
  Eigen::RowVectorXd force_factor(double share) const {
    // It was solved from a third of the push on; what is extrapolated must stay a ratio.
    constexpr double kLeast = 0.1;
    return (powers(share) * force_ratio).cwiseMax(kLeast);
  }
  // (terms) 1, share, share^2
  Eigen::RowVectorXd powers(double share) const {
    return Eigen::RowVector3d(1, share, share * share).head(differs.rows());
  }
};

// The way from rest to these pads by quadratic elements on scene's mesh and on its refinement, of the body as a fit has
// it, too fast for it to relax. Solved at three parts of the way, or at as many as finer elements have an equilibrium
// for, or have reached when `hurry` is set: beside a pad they fold where larger ones do not. Nothing once `stop` is.
FinerAnswer finer_answer(const Scene& scene, const Fit& at, std::span<const PadInput> pads,
                         const std::atomic<bool>& hurry, const std::atomic<bool>& stop);

// mm RMS per axis, of markers: what finer elements say otherwise of where the body comes to rest under its weight and
// these loads. Nothing where there are too many elements, or no equilibrium.
std::optional<double> finer_rest(const Scene& scene, std::span<const EdgeLoad> loads);

}  // namespace tissued::core
