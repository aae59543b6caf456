#include "core/fem_equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace tissued::core {

namespace {

double largest_move(const Eigen::VectorXd& field) {
  double square = 0.0;
  for (Eigen::Index i = 0; i < field.size(); i += 3) square = std::max(square, field.segment<3>(i).squaredNorm());
  return std::sqrt(square);
}

int furthest_node(const Eigen::VectorXd& field) {
  Eigen::Index node = 0;
  for (Eigen::Index i = 0; 3 * i < field.size(); ++i)
    if (field.segment<3>(3 * i).squaredNorm() > field.segment<3>(3 * node).squaredNorm()) node = i;
  return static_cast<int>(node);
}

void clear_held(const std::vector<std::uint8_t>& held, Eigen::VectorXd& field) {
  for (std::size_t i = 0; i < held.size(); ++i)
    if (held[i]) field.segment<3>(3 * static_cast<Eigen::Index>(i)).setZero();
}

}  // namespace

std::string FemReport::words() const {
  if (converged) return {};
  const char* why = trouble == FemTrouble::inverted     ? "element %d at (%.1f, %.1f, %.1f) mm turns inside out"
                    : trouble == FemTrouble::indefinite ? "the tangent is not definite, worst at node %d at "
                                                          "(%.1f, %.1f, %.1f) mm: the body buckles, or is not held"
                                                        : "Newton's corrections do not shrink, largest at node %d at "
                                                          "(%.1f, %.1f, %.1f) mm";
  char where[200], text[300];
  std::snprintf(where, sizeof where, why, trouble_index, trouble_at.x(), trouble_at.y(), trouble_at.z());
  std::snprintf(text, sizeof text, "%s beyond %.1f %% of the load, the last that converged", where, 100.0 * load);
  return text;
}

// One load on the way.
struct FemEquilibrium::Attempt {
  const FemBalance& balance;
  const FemHold& hold;
  const FemHistory& history;
  const FemControl& control;
  Eigen::VectorXd offset;  // of this load
};

FemEquilibrium::FemEquilibrium(const FemModel& model, int threads)
    : model_(&model), assembler_(model.pattern(), model.terms(), threads), factor_(model.pattern(), model.fixed()) {}

void FemEquilibrium::accept(const Eigen::VectorXd& x, double time_step, FemHistory& history) const {
  for (std::size_t t = 0; t < history.size(); ++t)
    model_->terms()[t]->accept({x.data(), time_step, history[t].data(), assembler_.pads()}, history[t].data());
}

std::vector<Vec3> FemEquilibrium::pressed(const Eigen::VectorXd& x, double time_step, const FemHistory& history) const {
  std::vector<Vec3> forces(model_->scene().pads.size(), Vec3::Zero());
  for (std::size_t t = 0; t < history.size(); ++t)
    model_->terms()[t]->add_pad_forces({x.data(), time_step, history[t].data(), assembler_.pads()}, forces);
  return forces;
}

Eigen::VectorXd FemEquilibrium::pressed_slope(int pad, const Vec3& axis, const Eigen::VectorXd& x, double time_step,
                                              const FemHistory& history) const {
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(x.size());
  for (std::size_t t = 0; t < history.size(); ++t)
    model_->terms()[t]->add_pad_slope(pad, axis, {x.data(), time_step, history[t].data(), assembler_.pads()}, slope);
  return slope;
}

// False where an element is inverted.
bool FemEquilibrium::evaluate(const Attempt& attempt, const Eigen::VectorXd& x, Eigen::VectorXd& residual) {
  const double energy = assembler_.evaluate(x, attempt.balance.time_step, attempt.history, residual, nullptr);
  residual *= attempt.balance.scale;
  if (attempt.balance.matrix != nullptr) {
    Eigen::VectorXd product;
    model_->pattern().multiply(*attempt.balance.matrix, x, product);
    residual += product;
  }
  residual += attempt.offset;
  return std::isfinite(energy);
}

void FemEquilibrium::tangent_at(const FemBalance& balance, const Eigen::VectorXd& x, const FemHistory& history) {
  Eigen::VectorXd residual;
  assembler_.evaluate(x, balance.time_step, history, residual, &values_);
  for (std::size_t k = 0; k < values_.size(); ++k) {
    values_[k] *= balance.scale;
    if (balance.matrix != nullptr) values_[k] += (*balance.matrix)[k];
  }
}

// Tangent and factor at x. Where the tangent is indefinite the diagonal is raised: still a direction of descent.
bool FemEquilibrium::refactor(const Attempt& attempt, const Eigen::VectorXd& x, FemReport& report) {
  tangent_at(attempt.balance, x, attempt.history);
  factor_held_ = attempt.hold.held;
  for (double shift : {0.0, 1e-3, 1e-2, 1e-1}) {
    ++report.factorizations;
    if (factor_.factorize(values_, attempt.hold.held, shift)) return true;
  }
  return false;
}

bool FemEquilibrium::factor_at(const FemBalance& balance, const Eigen::VectorXd& x, const FemHistory& history,
                               const FemHold& hold) {
  tangent_at(balance, x, history);
  const bool is_definite = factor_.factorize(values_, hold.held);
  factor_held_ = is_definite ? hold.held : std::vector<std::uint8_t>();
  return is_definite;
}

Eigen::VectorXd FemEquilibrium::unbalanced(const FemBalance& balance, const Eigen::VectorXd& x,
                                           const FemHistory& history) {
  const FemHold none;
  const FemControl control;
  Eigen::VectorXd residual;
  evaluate({balance, none, history, control, balance.offset}, x, residual);
  return residual;
}

void FemEquilibrium::blame(FemTrouble trouble, const Eigen::VectorXd& where, FemReport& report) const {
  report.trouble = trouble;
  const FemMesh& mesh = model_->mesh();
  const FemAssembler::Entity entity = assembler_.inverted();
  if (trouble == FemTrouble::inverted && entity.term >= 0) {
    report.trouble_index = entity.entity;
    report.trouble_at.setZero();
    const std::span<const int> nodes = model_->terms()[entity.term]->nodes_of_entity(entity.entity);
    for (int node : nodes) report.trouble_at += mesh.rest.row(node).transpose() / static_cast<double>(nodes.size());
    return;
  }
  report.trouble_index = furthest_node(where);
  report.trouble_at = mesh.rest.row(report.trouble_index).transpose();
}

// Goes along `direction` as far as its residual's work shrinks. Returns the share that was gone; 0: nowhere.
double FemEquilibrium::search(const Attempt& attempt, const Eigen::VectorXd& direction, Eigen::VectorXd& x,
                              Eigen::VectorXd& residual, FemReport& report) {
  constexpr int kTrials = 10;
  constexpr double kShrunk = 0.8;
  const double begin = direction.dot(residual);
  const bool is_polish = largest_move(direction) < 1e3 * attempt.control.tolerance;  // rounding rules there
  double share = 1.0;
  Eigen::VectorXd trial, trial_residual;
  for (int k = 0; k < kTrials; ++k) {
    trial = x + share * direction;
    if (!evaluate(attempt, trial, trial_residual)) {
      blame(FemTrouble::inverted, direction, report);
      share *= 0.5;
      continue;
    }
    const double end = direction.dot(trial_residual);
    if (is_polish || end <= 0.0 || end <= kShrunk * std::abs(begin)) {
      x.swap(trial);
      residual.swap(trial_residual);
      return share;
    }
    share *= std::clamp(begin / (begin - end), 0.1, 0.7);
  }
  return 0.0;
}

// Newton's corrections at fixed held nodes. The factor is kept while its corrections shrink fast enough: a solve costs
// a small part of a factorisation.
bool FemEquilibrium::correct(const Attempt& attempt, Eigen::VectorXd& x, Eigen::VectorXd& residual, FemReport& report) {
  constexpr double kWorthKeeping = 0.5;
  const FemControl& control = attempt.control;
  double last = std::numeric_limits<double>::infinity();
  bool is_fresh = false;
  for (int k = 0; k < control.max_corrections; ++k) {
    Eigen::VectorXd direction = factor_.solve(-residual);
    ++report.corrections;
    report.correction = largest_move(direction);
    if (!std::isfinite(report.correction) || control.stopped()) return false;
    const bool is_small = report.correction < control.tolerance;
    if (!is_fresh && !is_small && report.correction > kWorthKeeping * last) {
      if (!refactor(attempt, x, report)) {
        blame(FemTrouble::indefinite, direction, report);
        return false;
      }
      is_fresh = true;
      last = std::numeric_limits<double>::infinity();
      continue;
    }
    const double share = search(attempt, direction, x, residual, report);
    if (share == 0.0) {
      if (report.trouble == FemTrouble::none) blame(FemTrouble::stalled, direction, report);
      return false;
    }
    if (is_small) return true;
    last = share * report.correction;
    is_fresh = false;
    if (k + 1 == control.max_corrections) blame(FemTrouble::stalled, direction, report);
  }
  return false;
}

// Held nodes move by `increment`, the others with them along the tangent; then the corrections.
bool FemEquilibrium::attempt_load(const Attempt& attempt, const Eigen::VectorXd& increment, Eigen::VectorXd& x,
                                  FemReport& report) {
  const Eigen::VectorXd start = x;
  Eigen::VectorXd residual, product;
  if (!evaluate(attempt, start, residual)) {
    blame(FemTrouble::inverted, increment, report);
    return false;
  }
  const Eigen::VectorXd unbalanced = residual;
  bool is_fresh = false;
  for (;;) {
    if (!factor_.ready() || factor_held_ != attempt.hold.held) {
      if (!refactor(attempt, start, report)) {
        blame(FemTrouble::indefinite, unbalanced, report);
        return false;
      }
      is_fresh = true;
    }
    model_->pattern().multiply(values_, increment, product);
    ++report.corrections;
    x = start + increment + factor_.solve(-unbalanced - product);
    if (evaluate(attempt, x, residual)) break;
    blame(FemTrouble::inverted, increment, report);
    if (is_fresh) return false;
    factor_held_.clear();  // an old tangent led astray: once more with a new one
  }
  return correct(attempt, x, residual, report);
}

FemReport FemEquilibrium::find(const FemBalance& balance, const FemHold& hold, const FemHistory& history,
                               const FemControl& control, Eigen::VectorXd& x) {
  set_pads(hold.pads);
  FemReport report;
  Attempt attempt{balance, hold, history, control, balance.offset};
  Eigen::VectorXd start_residual, way = Eigen::VectorXd::Zero(x.size());
  for (std::size_t i = 0; i < hold.held.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    if (hold.held[i]) way.segment<3>(at) = hold.position.segment<3>(at) - x.segment<3>(at);
  }
  if (!evaluate(attempt, x, start_residual)) {
    blame(FemTrouble::inverted, way, report);
    return report;
  }
  clear_held(hold.held, start_residual);
  const double distance = largest_move(way);
  double step = distance > control.largest_move ? control.largest_move / distance : 1.0;
  while (report.load < 1.0) {
    // The last step is not left as a splinter.
    const double rest = 1.0 - report.load;
    const double share = step >= 0.999 * rest ? rest : step;
    const double load = share == rest ? 1.0 : report.load + share;
    Eigen::VectorXd trial = x;
    attempt.offset = balance.offset - (1.0 - load) * start_residual;
    const int corrections = report.corrections;
    report.trouble = FemTrouble::none;
    if (attempt_load(attempt, share * way, trial, report)) {
      x.swap(trial);
      report.load = load;
      ++report.load_steps;
      constexpr int kEasy = 8;
      if (report.corrections - corrections <= kEasy) step *= 2.0;
      step = std::min(step, distance > control.largest_move ? control.largest_move / distance : 1.0);
      continue;
    }
    ++report.cut_steps;
    factor_held_.clear();
    step = 0.4 * share;
    if (step < control.smallest_load || report.corrections > control.most_corrections || control.stopped()) break;
  }
  report.converged = report.load == 1.0;
  Eigen::VectorXd residual;
  evaluate(attempt, x, residual);
  clear_held(hold.held, residual);
  report.force_residual = largest_move(residual) / kMillinewtonPerNewton;
  return report;
}

}  // namespace tissued::core
