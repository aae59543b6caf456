// The models of a session that all fits share: what is known to be wrong of each, and what makes the answers of coarse
// elements those of finer ones.
#pragma once

#include <algorithm>

#include "core/diagnosis/work.hpp"

namespace tissued::core {

// Noise as it is seen, markers' places, and what quadratic elements err in forces.
ErrorModel error_model(const RecordedSession& session);

// travel: mm between keys. Without any correction.
FitData fit_data(const RecordedSession& session, double travel, FemElement element, const ErrorModel& errors,
                 const std::atomic<bool>* stop);

// Likewise of a session with motions, by quadratic elements.
FitData fit_data(const RecordedSession& session, const MotionSteps& steps, const ErrorModel& errors,
                 const std::atomic<bool>* stop);

// What markers do that sit elsewhere than the scene has them, and how little is known of that.
void place_markers(FitData& data);

struct FinerJudgement {
  double rms_mm = 0.0;          // what markers differ by at the peaks; 0 where nothing was judged
  std::vector<double> reached;  // (trials in which anything is pushed) share of the push that was judged; 0: none
  bool hurried = false;         // the time did not suffice

  std::size_t judged() const {
    return static_cast<std::size_t>(std::count_if(reached.begin(), reached.end(), [](double r) { return r > 0.0; }));
  }
};

// What finer elements answer on the way to the peak of each trial, into `exact`, of the body as a fit has it. Trials
// that could not be judged to the end of their push are known less well.
FinerJudgement correct_by_finer(const Fit& at, Work& work, double most_of_budget, FitData& exact);

// Makes the answers of linear elements those of quadratic ones where nothing is left out.
void correct_by_quadratic(FitData& fast);

// Makes the answers of linear elements those of quadratic ones at a fit by these, wherever that lies.
void rebase(const FitData& exact, const Fit& at, FitData& fast);

}  // namespace tissued::core
