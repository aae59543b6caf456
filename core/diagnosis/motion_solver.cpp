#include "core/diagnosis/motion_solver.hpp"

#include <algorithm>

#include "core/edge_load.hpp"
#include "core/fem_dynamics.hpp"

namespace tissued::core {

namespace {

constexpr FemControl kControl{1e-3, 30, 6.0, 1e-3};  // derivatives are of bodies as much out of balance
// With hardly any damping of its own: of what swings with a period of 25 steps, less than 1e-4 of the critical one.
constexpr TimeScheme kSwinging{TimeScheme::Kind::generalized_alpha, 0.9};
// Long steps are to end where the body comes to rest.
constexpr TimeScheme kSettling{TimeScheme::Kind::implicit_euler};

// The loads of a trial with the mass that the body's numbers give them: attached-mass.mass is that of a load of
// attached-mass.load N, and others have theirs in proportion to their forces.
std::vector<EdgeLoad> loads_with_mass(const PathSolver& body, const Motion& motion, double mass) {
  std::vector<EdgeLoad> loads = motion.loads;
  if (const double reference = body.value("attached-mass.load"); reference > 0.0)
    for (EdgeLoad& load : loads) load.mass += mass * load.force.norm() / reference;
  return loads;
}

FemDynamics dynamics_of(PathSolver& body, const Motion& motion, double mass) {
  return {body.equilibrium(), kSwinging, {}, masses_of(body.model(), loads_with_mass(body, motion, mass))};
}

// A body with one of its numbers to the side, that goes along.
struct Companion {
  const PathParameter* parameter;
  FemDynamics dynamics;
  FemState state;
};

class MotionRun {
 public:
  MotionRun(PathSolver& body, const LoadPath& path, std::span<const PathParameter> parameters)
      : body_(&body),
        path_(&path),
        external_(forces_of(body.model(), path.motion()->loads)),
        dynamics_(dynamics_of(body, *path.motion(), body.value("attached-mass.mass"))),
        state_(rest_state(body.model())) {
    for (const PathParameter& parameter : parameters) {
      body.shift(parameter);
      const double beside = parameter.name == "attached-mass.mass" ? parameter.step : 0.0;
      companions_.push_back(
          {&parameter, dynamics_of(body, *path.motion(), body.value("attached-mass.mass") + beside), state_});
      body.unshift(parameter);
    }
    dynamics_.keep_matrices();
  }

  bool run(PathAnswer& answer, std::string& trouble) {
    const std::vector<LoadKey>& keys = path_->keys();
    const Motion& motion = *path_->motion();
    std::size_t begin = 0;
    while (begin + 1 < keys.size() && keys[begin].time < motion.release - 1e-9) ++begin;
    if (!motion.held_undeformed && !settle(keys.front(), trouble)) return false;
    for (std::size_t k = 0; k <= begin; ++k) show(keys[k], k, answer);
    start(keys[begin]);
    for (std::size_t k = begin + 1; k < keys.size(); ++k) {
      if (keys[k].settles != keys[k - 1].settles) use(keys[k].settles ? kSettling : kSwinging);
      if (!step(keys[k], keys[k].time - keys[k - 1].time, trouble)) return false;
      show(keys[k], k, answer);
    }
    return true;
  }

 private:
  FemLoads loads_at(const LoadKey& key) const { return {key.pads, &external_}; }

  // To the equilibrium that the trial begins with.
  bool settle(const LoadKey& key, std::string& trouble) {
    FemEquilibrium& equilibrium = body_->equilibrium();
    const FemState before = state_;
    equilibrium.forget_factor();
    const FemReport report = solve_static(equilibrium, state_, loads_at(key), kControl);
    if (!report.converged) {
      trouble = report.words();
      return false;
    }
    FemBalance balance;
    balance.offset = -external_forces(body_->model(), loads_at(key));
    if (companions_.empty() || !equilibrium.factor_at(balance, state_.x, before.history, state_.hold)) return true;
    for (Companion& companion : companions_) {
      body_->shift(*companion.parameter);
      companion.state.hold = state_.hold;
      companion.state.x =
          state_.x - equilibrium.factor().solve(equilibrium.unbalanced(balance, state_.x, companion.state.history));
      equilibrium.accept(companion.state.x, 0.0, companion.state.history);
      body_->unshift(*companion.parameter);
    }
    dynamics_.keep_matrices();
    return true;
  }

  void start(const LoadKey& key) {
    for (Companion& companion : companions_) {
      body_->shift(*companion.parameter);
      companion.dynamics.keep_matrices();
      companion.dynamics.start(companion.state, loads_at(key));
      body_->unshift(*companion.parameter);
    }
    dynamics_.keep_matrices();
    dynamics_.start(state_, loads_at(key));
  }

  void use(const TimeScheme& scheme) {
    dynamics_.use(scheme);
    for (Companion& companion : companions_) companion.dynamics.use(scheme);
  }

  bool step(const LoadKey& key, double dt, std::string& trouble) {
    const FemState before = state_;
    const FemReport report = dynamics_.step(state_, loads_at(key), dt, kControl);
    if (!report.converged) {
      trouble = report.words();
      return false;
    }
    if (companions_.empty()) return true;
    const auto guide = dynamics_.guide(before, state_, loads_at(key), dt);
    if (!guide) {
      trouble = "the motion has no derivatives";
      return false;
    }
    for (Companion& companion : companions_) {
      body_->shift(*companion.parameter);
      companion.dynamics.keep_matrices();
      companion.dynamics.follow(*guide, companion.state, loads_at(key), dt);
      body_->unshift(*companion.parameter);
    }
    dynamics_.keep_matrices();
    return true;
  }

  void show(const LoadKey& key, std::size_t row, PathAnswer& answer) const {
    const auto at = static_cast<Eigen::Index>(row);
    const Eigen::RowVectorXd seen = body_->observe(state_, key.pads);
    answer.values.row(at) = seen;
    for (std::size_t j = 0; j < companions_.size(); ++j)
      answer.by_parameter[j].row(at) =
          (body_->observe(companions_[j].state, key.pads) - seen) / companions_[j].parameter->step;
  }

  PathSolver* body_;
  const LoadPath* path_;
  Eigen::VectorXd external_;  // (3n) mN
  FemDynamics dynamics_;
  FemState state_;
  std::vector<Companion> companions_;
};

}  // namespace

bool solve_motion(PathSolver& body, const LoadPath& path, std::span<const PathParameter> parameters, PathAnswer& answer,
                  std::string& trouble) {
  const auto keys = static_cast<Eigen::Index>(path.keys().size());
  answer.values.setZero(keys, channels_of(body.model().scene()).count());
  answer.by_parameter.assign(parameters.size(), answer.values);
  return MotionRun(body, path, parameters).run(answer, trouble);
}

}  // namespace tissued::core
