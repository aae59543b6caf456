// What a body with given effects would show along the paths of the pads, and how that changes with its numbers.
#pragma once

#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/diagnosis/load_path.hpp"
#include "core/effects/effect.hpp"
#include "core/fem_solver.hpp"

namespace tissued::core {

// A number of the model (FemModel::set_parameter) and the step of the differences by which answers are differentiated.
struct PathParameter {
  std::string name;
  double step;  // may be negative, where the value is at its upper bound
  // Other numbers that are set together with the step and back again: those that change nothing where `name` is now,
  // such as the place of an effect that is absent.
  std::vector<std::pair<std::string, double>> with = {};
};

struct PathAnswer {
  RowMatrix values;                     // (keys x channels), as RecordedTrial::seen
  std::vector<RowMatrix> by_parameter;  // (parameters) of the same shape, per unit
};

// Owns a body. Not for two threads at once.
class PathSolver {
 public:
  // Throws ModelError, as FemModel.
  PathSolver(const Scene& scene, std::vector<const Effect*> effects, FemElement element = FemElement::p2);

  void set_parameter(const std::string& name, double value) {
    model_.set_parameter(name, value);
    values_[name] = value;
  }

  // Parameters must have been set before. Equilibria at the keys of a path; `slot` names the path from call to call, so
  // that the next solve with other numbers begins where this one ended. Derivatives are exact along the path: what the
  // body remembers is perturbed, too. False where a key has no equilibrium that Newton finds; `trouble` then says why.
  bool solve(const LoadPath& path, int slot, std::span<const PathParameter> parameters, PathAnswer& answer);

  // Of two numbers that are differentiated by: to the side, and back.
  void shift(const PathParameter& parameter);
  void unshift(const PathParameter& parameter);
  // The last that was set; 0 where none was.
  double value(const std::string& name) const;

  const std::string& trouble() const { return trouble_; }
  // Newton's, of the last solve; and how many a solve may take before it is given up.
  int corrections() const { return corrections_; }
  void set_patience(int most_corrections) { most_corrections_ = most_corrections; }
  bool has_history() const { return has_history_; }
  const FemModel& model() const { return model_; }
  FemEquilibrium& equilibrium() { return equilibrium_; }
  // (3n) mm, of the last solve in that slot: where the body is at each key. Elastic bodies share them between keys of
  // one pose.
  const std::vector<Eigen::VectorXd>& positions(int slot) const { return positions_[static_cast<std::size_t>(slot)]; }

  Eigen::RowVectorXd observe(const FemState& state, std::span<const PadInput> pads) const;

 private:
  FemReport find(const LoadKey& key, double time_step, FemState& state);
  bool solve_key(const LoadKey& key, double time_step, const Eigen::VectorXd* start, FemState& state);
  void differentiate(const LoadKey& key, double time_step, const FemHistory& before, const FemState& state,
                     std::span<const PathParameter> parameters, std::vector<FemHistory>& perturbed,
                     std::vector<Eigen::RowVectorXd>& derivatives);

  FemModel model_;
  FemEquilibrium equilibrium_;
  bool has_history_ = false;
  Channels channels_;
  Eigen::VectorXd rest_;
  std::vector<std::vector<Eigen::VectorXd>> positions_;  // (slots) (keys)
  std::map<std::string, double> values_;                 // that were set
  std::string trouble_;
  int corrections_ = 0, most_corrections_ = std::numeric_limits<int>::max();
};

}  // namespace tissued::core
