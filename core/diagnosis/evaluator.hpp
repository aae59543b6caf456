// A hypothesis with given unknowns, compared with every trial. Owns its body.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "core/diagnosis/fit.hpp"

namespace tissued::core {

constexpr double kStepOfDifference = 1e-5;  // of what is typical, in derivatives by numbers of the body

class Evaluator {
 public:
  // Both must outlive it.
  Evaluator(const FitData& data, const Hypothesis& hypothesis);

  // Derivatives that are taken beside those by unknowns.
  void add_column(PathParameter column) { columns_.push_back(std::move(column)); }
  void set(const std::string& name, double value) {
    for (PathSolver& solver : solvers_) solver.set_parameter(name, value);
  }

  // Fills answers and residuals of `fit`. False where a trial has no equilibrium (fit.trouble), is so much harder to
  // solve than with the first numbers that were solved for that it is given up, or where `stop` was set.
  bool run(const std::vector<Unknown>& unknowns, bool differentiate, Fit& fit);

 private:
  void take_off(const std::vector<Unknown>& unknowns, bool differentiate, Fit& fit) const;
  RowMatrix scaled(int trial, double share, const RowMatrix& answers) const;
  void compare(int trial, const std::vector<Unknown>& unknowns, bool differentiate, const PathAnswer& answer,
               TrialResidual& out) const;

  const FitData* data_;
  const Hypothesis* hypothesis_;
  // One for all trials, which goes from one to the next; of motions, which take long, one for each.
  std::deque<PathSolver> solvers_;
  std::vector<int> usual_corrections_;  // (trials) of the first run that was solved; empty: none was
  std::vector<PathParameter> columns_;
};

}  // namespace tissued::core
