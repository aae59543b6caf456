// Newton's method for one balance of forces, and the path that leads there when the way is far.
#pragma once

#include <atomic>
#include <limits>
#include <string>

#include "core/fem_assembler.hpp"
#include "core/fem_factor.hpp"
#include "core/fem_model.hpp"

namespace tissued::core {

struct FemControl {
  double tolerance = 1e-8;      // mm; largest move of a node in the last Newton correction
  int max_corrections = 40;     // of one load step
  double largest_move = 12.0;   // mm; a held node moves by at most this much in a load step
  double smallest_load = 1e-3;  // share of the load; a step that would have to be smaller is given up
  int most_corrections = std::numeric_limits<int>::max();  // of all load steps; where one fails beyond, all is given up
  const std::atomic<bool>* stop = nullptr;                 // set: everything is given up
  bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

// What balances: scale (terms(x) - external) + matrix x + offset = 0 at free nodes.
struct FemBalance {
  double scale = 1.0;
  double time_step = 0.0;                       // s, for terms with history
  const std::vector<double>* matrix = nullptr;  // of the pattern, mN/mm; inertia and damping
  Eigen::VectorXd offset;                       // (3n) mN, minus what the external forces are (scaled)
};

// What holds.
struct FemHold {
  std::vector<std::uint8_t> held;  // (n), the fixed nodes included
  Eigen::VectorXd position;        // (3n) mm, read at held nodes
  std::vector<int> pad;            // (n) that holds the node; -1: none
  std::vector<PadInput> pads;      // for terms that press pads on
};

enum class FemTrouble { none, inverted, stalled, indefinite };

struct FemReport {
  bool converged = false;
  double load = 0.0;    // share of the way from the state before to what was asked that was reached
  int load_steps = 0;   // that converged
  int cut_steps = 0;    // that were tried, failed and cut
  int corrections = 0;  // solves
  int factorizations = 0;
  double correction = 0.0;      // mm, largest move of a node in the last correction
  double force_residual = 0.0;  // N, largest unbalanced force at a free node
  FemTrouble trouble = FemTrouble::none;
  Vec3 trouble_at = Vec3::Zero();  // mm, tissue, at rest: the inverted element's middle, or the node that stalled
  int trouble_index = -1;          // element or node
  std::string words() const;       // empty where it converged
};

// Equilibria of one model; owns what is reused from one to the next: slices, values, factor. Not for two threads at
// once.
class FemEquilibrium {
 public:
  FemEquilibrium(const FemModel& model, int threads);

  // Moves x from where it is to the balance. What is out of balance at the start is taken away along the way, as held
  // nodes move to their positions. Where that fails, x is at the last load that converged.
  FemReport find(const FemBalance& balance, const FemHold& hold, const FemHistory& history, const FemControl& control,
                 Eigen::VectorXd& x);

  // The terms' forces at x, (3n) mN, and their tangent where asked; with the pads of the last `find` or `set_pads`.
  double terms(const Eigen::VectorXd& x, double time_step, const FemHistory& history, Eigen::VectorXd& residual,
               std::vector<double>* values = nullptr) {
    return assembler_.evaluate(x, time_step, history, residual, values);
  }
  void set_pads(std::span<const PadInput> pads) { assembler_.set_pads(pads); }
  // (pads of the scene) N: of terms that press pads on. Zero where the pads hold their nodes.
  std::vector<Vec3> pressed(const Eigen::VectorXd& x, double time_step, const FemHistory& history) const;
  // (3n) N/mm: derivative of one of these forces along an axis by x.
  Eigen::VectorXd pressed_slope(int pad, const Vec3& axis, const Eigen::VectorXd& x, double time_step,
                                const FemHistory& history) const;
  // The state at x follows on `history` after time_step, which becomes its own.
  void accept(const Eigen::VectorXd& x, double time_step, FemHistory& history) const;
  // Factors the tangent of the balance at x, to be used for derivatives there; the next solve begins with it. Pads are
  // those of the last `find` or `set_pads`. False where it is not definite.
  bool factor_at(const FemBalance& balance, const Eigen::VectorXd& x, const FemHistory& history, const FemHold& hold);
  // (3n) mN, what is out of balance at x.
  Eigen::VectorXd unbalanced(const FemBalance& balance, const Eigen::VectorXd& x, const FemHistory& history);
  // The next solve begins with a tangent of its own: the balance became another one.
  void forget_factor() { factor_held_.clear(); }
  FemAssembler& assembler() { return assembler_; }
  FemFactor& factor() { return factor_; }
  const FemModel& model() const { return *model_; }

 private:
  struct Attempt;
  bool evaluate(const Attempt& attempt, const Eigen::VectorXd& x, Eigen::VectorXd& residual);
  void tangent_at(const FemBalance& balance, const Eigen::VectorXd& x, const FemHistory& history);
  bool refactor(const Attempt& attempt, const Eigen::VectorXd& x, FemReport& report);
  bool attempt_load(const Attempt& attempt, const Eigen::VectorXd& increment, Eigen::VectorXd& x, FemReport& report);
  bool correct(const Attempt& attempt, Eigen::VectorXd& x, Eigen::VectorXd& residual, FemReport& report);
  double search(const Attempt& attempt, const Eigen::VectorXd& direction, Eigen::VectorXd& x, Eigen::VectorXd& residual,
                FemReport& report);
  void blame(FemTrouble trouble, const Eigen::VectorXd& where, FemReport& report) const;

  const FemModel* model_;
  FemAssembler assembler_;
  FemFactor factor_;
  std::vector<double> values_;  // of the last tangent
  std::vector<std::uint8_t> factor_held_;
};

}  // namespace tissued::core
