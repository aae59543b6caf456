// Sums terms into one residual and one tangent. Entities are evaluated in parallel into slices of their own; then every
// node and every block of the matrix gathers its contributions in a fixed order: the same bits for any number of
// threads.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/fem_pattern.hpp"
#include "core/fem_term.hpp"

namespace tissued::core {

// History of every term, in the order of the terms.
using FemHistory = std::vector<std::vector<double>>;

class FemAssembler {
 public:
  // Keeps references to both. threads: at least 1.
  FemAssembler(const FemPattern& pattern, const std::vector<std::unique_ptr<FemTerm>>& terms, int threads);

  // Energy, kPa mm3: infinite where an entity is inverted. residual: (3n) mN; values: of the pattern, mN/mm, or null.
  double evaluate(const Eigen::VectorXd& x, double time_step, const FemHistory& history, Eigen::VectorXd& residual,
                  std::vector<double>* values);
  // (3n) mN per unit of the parameter.
  void differentiate(int term, int parameter, const Eigen::VectorXd& x, double time_step, const FemHistory& history,
                     Eigen::VectorXd& residual);

  struct Entity {
    int term = -1, entity = -1;
  };
  // The first entity that was inverted in the last evaluate; term -1 where none was.
  Entity inverted() const;
  // (nodes x 3) mN of an entity in the last evaluate.
  std::span<const double> residual_of(const Entity& entity) const;

  // What the pads do, for terms that ask; none to begin with.
  void set_pads(std::span<const PadInput> pads) { pads_.assign(pads.begin(), pads.end()); }
  std::span<const PadInput> pads() const { return pads_; }
  int threads() const { return threads_; }

 private:
  struct Slot {
    std::size_t energy, residual, tangent;  // where the term's slices begin
  };
  // Entities of one term that are evaluated together.
  struct Range {
    std::size_t term;
    int begin, end;
  };
  struct Contribution {
    std::size_t offset;
    bool transposed;
  };
  void gather_residual(Eigen::VectorXd& residual) const;
  void gather_tangent(int threads, std::vector<double>& values) const;
  int threads_for(std::size_t numbers) const;
  TermInput input_of(std::size_t term, const Eigen::VectorXd& x, double time_step, const FemHistory& history) const;
  template <typename Work>
  void for_each_range(int threads, const Work& work) const;

  const FemPattern* pattern_;
  const std::vector<std::unique_ptr<FemTerm>>* terms_;
  int threads_;
  std::vector<PadInput> pads_;
  std::vector<Slot> slots_;
  std::vector<Range> ranges_;
  std::vector<double> energy_, residual_, tangent_;
  std::vector<std::size_t> residual_begin_, residual_from_;  // per node: offsets into residual_
  std::vector<std::size_t> tangent_begin_;                   // per block of the pattern
  std::vector<Contribution> tangent_from_;
};

}  // namespace tissued::core
