#include "core/static_solve.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/admm.hpp"
#include "core/anderson.hpp"
#include "core/neo_hookean.hpp"

namespace tissued::core {

namespace {

constexpr int kStateSize = 9 * kLanes;

Mat3 deformation_gradient(const StrainDomain& domain, const NodeField& x) {
  Mat3 f = Mat3::Zero();
  const Vec3 first = x.row(domain.nodes[0]).head<3>().transpose();
  for (std::size_t a = 1; a < domain.nodes.size(); ++a)
    f += (x.row(domain.nodes[a]).head<3>().transpose() - first) * domain.gradients[a].transpose();
  return f;
}

// Dx of every domain, laid out like DomainState::u.
void gradients(const Model& model, const NodeField& x, Eigen::VectorXd& out) {
  for (std::size_t slot = 0; slot < model.blocks().domain.size(); ++slot) {
    const int domain = model.blocks().domain[slot];
    if (domain < 0) continue;
    const Mat3 f = deformation_gradient(model.domains()[domain], x);
    const auto at = static_cast<Eigen::Index>(slot / kLanes) * kStateSize + static_cast<Eigen::Index>(slot % kLanes);
    for (int i = 0; i < 9; ++i) out[at + i * kLanes] = f(i / 3, i % 3);
  }
}

// External less internal force of (11) at every node, mN.
NodeField unbalanced_force(const Model& model, const NodeField& x, const NodeField& external, int& inverted) {
  NodeField force = external;
  inverted = 0;
  for (const StrainDomain& domain : model.domains()) {
    const Mat3 f = deformation_gradient(domain, x);
    if (!(f.determinant() > 0)) {
      ++inverted;
      continue;
    }
    const Mat3 stress = domain.volume * first_piola(domain.shear_modulus, domain.bulk_modulus, f);
    for (std::size_t a = 0; a < domain.nodes.size(); ++a)
      force.row(domain.nodes[a]).head<3>() -= (stress * domain.gradients[a]).transpose();
  }
  return force;
}

struct Balance {
  double displacement;  // mm
  double force;         // N
  int inverted;
};

// How far x is from equilibrium: L^-1 of the unbalanced force, held nodes not counted.
Balance balance_of(const Model& model, const AdmmState& state, const AdmmWorkspace& workspace) {
  Balance balance{};
  const NodeField force = unbalanced_force(model, state.x, workspace.external, balance.inverted);
  std::vector<std::uint8_t> is_held(static_cast<std::size_t>(force.rows()), 0);
  for (int k = 0; k < workspace.held.count(); ++k) is_held[workspace.held.node(k)] = 1;
  const std::vector<int>& free = model.system().free_nodes();
  Eigen::MatrixXd right(static_cast<Eigen::Index>(free.size()), 3);
  for (std::size_t i = 0; i < free.size(); ++i) {
    right.row(static_cast<Eigen::Index>(i)).setZero();
    if (is_held[free[i]]) continue;
    right.row(static_cast<Eigen::Index>(i)) = force.row(free[i]).head<3>();
  }
  balance.force = right.rows() == 0 ? 0.0 : right.rowwise().norm().maxCoeff() / kMillinewtonPerNewton;
  balance.displacement = right.rows() == 0 ? 0.0 : model.system().factor().solve(right).rowwise().norm().maxCoeff();
  return balance;
}

// One load: ADMM iterations with safeguarded Anderson acceleration of p = Dx + u, the variable whose map ADMM iterates
// (Douglas-Rachford form).
class AcceleratedAdmm {
 public:
  AcceleratedAdmm(const Model& model, AdmmState& state, AdmmWorkspace& workspace, const StaticOptions& options)
      : model_(model),
        state_(state),
        workspace_(workspace),
        options_(options),
        anderson_(weights(model), options.anderson_depth),
        p_(static_cast<Eigen::Index>(model.blocks().count()) * kStateSize),
        mapped_(p_.size()),
        safe_(p_.size()),
        gradient_(Eigen::VectorXd::Zero(p_.size())) {}

  // A new load: the map is another one.
  void restart() {
    anderson_.forget();
    last_residual_ = std::numeric_limits<double>::infinity();
    accelerated_ = false;
    gradients(model_, state_.x, gradient_);
    read_p(p_);
  }

  // Returns a cheap measure of what is left: mm, move of the nodes and gap of the domains.
  double iterate(StaticSolution& solution) {
    const LocalStepResult local = local_stage(model_, state_, workspace_);
    const double move = global_stage(model_, state_, workspace_, kQuasiStatic);
    gradients(model_, state_.x, gradient_);
    read_p(mapped_);
    const double residual = anderson_.residual_norm(p_, mapped_);
    if (accelerated_ && residual > 2.0 * last_residual_) {
      // The accelerated iterate was worse than the plain one would have been: take that one and start a new history.
      ++solution.rejected;
      anderson_.forget();
      accelerated_ = false;
      write_p(safe_);
      return std::max(local.primal, move);
    }
    last_residual_ = residual;
    safe_ = mapped_;
    if (options_.anderson_depth > 0) {
      write_p(anderson_.mix(p_, mapped_));
      accelerated_ = true;
      ++solution.accelerated;
    } else {
      p_ = mapped_;
    }
    return std::max(local.primal, move);
  }

 private:
  static Eigen::VectorXd weights(const Model& model) {
    Eigen::VectorXd w(static_cast<Eigen::Index>(model.blocks().count()) * kStateSize);
    for (int b = 0; b < model.blocks().count(); ++b) {
      const DomainBlock& block = model.blocks().blocks[b];
      for (int i = 0; i < kStateSize; ++i)
        w[static_cast<Eigen::Index>(b) * kStateSize + i] = block.stiffness[i % kLanes] * block.volume[i % kLanes];
    }
    return w;
  }

  double* dual(std::size_t block) { return &state_.domains[block].u[0][0]; }

  void read_p(Eigen::VectorXd& p) {
    for (std::size_t b = 0; b < state_.domains.size(); ++b) {
      const auto at = static_cast<Eigen::Index>(b) * kStateSize;
      p.segment(at, kStateSize) =
          gradient_.segment(at, kStateSize) + Eigen::Map<const Eigen::VectorXd>(dual(b), kStateSize);
    }
  }

  void write_p(const Eigen::VectorXd& p) {
    p_ = p;
    for (std::size_t b = 0; b < state_.domains.size(); ++b) {
      const auto at = static_cast<Eigen::Index>(b) * kStateSize;
      Eigen::Map<Eigen::VectorXd>(dual(b), kStateSize) = p_.segment(at, kStateSize) - gradient_.segment(at, kStateSize);
    }
  }

  const Model& model_;
  AdmmState& state_;
  AdmmWorkspace& workspace_;
  const StaticOptions& options_;
  Anderson anderson_;
  Eigen::VectorXd p_, mapped_, safe_, gradient_;
  double last_residual_ = std::numeric_limits<double>::infinity();
  bool accelerated_ = false;
};

// The pads at a share of their way.
std::vector<PadInput> scaled(const Scene& scene, std::span<const PadInput> pads, double share) {
  std::vector<PadInput> out(pads.begin(), pads.end());
  for (std::size_t p = 0; p < out.size(); ++p) {
    out[p].center = scene.pads[p].center + share * (pads[p].center - scene.pads[p].center);
    out[p].force = share * pads[p].force;
    const Eigen::AngleAxisd turn(pads[p].rotation);
    out[p].rotation = Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix();
  }
  return out;
}

int load_steps(const Scene& scene, std::span<const PadInput> pads, double load_step) {
  double furthest = 0.0;
  for (std::size_t p = 0; p < pads.size(); ++p)
    if (pads[p].kind == PadInput::Kind::pose)
      furthest = std::max(furthest, (pads[p].center - scene.pads[p].center).norm());
  return std::max(1, static_cast<int>(std::ceil(furthest / load_step - 1e-9)));
}

// Tells a limit cycle from progress: no better than `kProgress` of the best residual for `kPatience` iterations.
class StallWatch {
 public:
  bool stalled(int iteration, double residual) {
    constexpr double kProgress = 0.7;
    constexpr int kPatience = 200;
    if (residual < kProgress * best_) {
      best_ = residual;
      since_ = iteration;
    }
    return iteration - since_ > kPatience;
  }

 private:
  double best_ = std::numeric_limits<double>::infinity();
  int since_ = 0;
};

std::string describe_trouble(const char* what, const StaticSolution& solution, double load) {
  char text[200];
  std::snprintf(text, sizeof text, "%s after %d iterations at %.0f %% of the load, weights x %g: residual %.3g mm",
                what, solution.iterations, 100.0 * load, solution.weight_scale, solution.residual);
  return text;
}

enum class Ending { converged, stalled, exhausted };

// The whole load with one set of weights.
Ending attempt(const Scene& scene, std::span<const PadInput> pads, const StaticOptions& options,
               const std::function<void(const StaticIteration&)>& watch, StaticSolution& solution) {
  constexpr double kIntermediate = 1e-2;  // mm; loads on the way need not be exact
  constexpr int kCheckEvery = 5;          // iterations; the true balance costs about as much as one
  const Model model(scene, options.element, solution.weight_scale, kQuasiStatic);
  AdmmState state(model);
  AdmmWorkspace workspace(model, resolve_threads(options.threads, scene.mesh.tet_count()));
  AcceleratedAdmm solver(model, state, workspace, options);
  Ending ending = Ending::converged;
  double load = 0.0;
  const int steps = load_steps(scene, pads, options.load_step);
  for (int step = 1; step <= steps && ending == Ending::converged; ++step) {
    load = static_cast<double>(step) / steps;
    const double goal = step == steps ? options.tolerance : std::max(options.tolerance, kIntermediate);
    begin_step(model, state, workspace, scaled(scene, pads, load), kQuasiStatic,
               std::numeric_limits<double>::infinity());
    solver.restart();
    StallWatch stall;
    bool converged = false;
    const int begin = solution.iterations;
    while (!converged && ending == Ending::converged) {
      const double cheap = solver.iterate(solution);
      ++solution.iterations;
      const bool exhausted = solution.iterations >= options.max_iterations;
      if (watch || exhausted || cheap < 10.0 * goal || solution.iterations % kCheckEvery == 0) {
        const Balance balance = balance_of(model, state, workspace);
        solution.residual = balance.displacement;
        solution.force_residual = balance.force;
        solution.inverted = balance.inverted;
        if (watch) watch({solution.iterations, load, balance.displacement});
        converged = balance.inverted == 0 && balance.displacement < goal;
        if (!converged && stall.stalled(solution.iterations - begin, balance.displacement)) ending = Ending::stalled;
      }
      if (!converged && exhausted) ending = Ending::exhausted;
    }
  }
  solution.positions = state.x;
  solution.pad_forces.assign(scene.pads.size(), Vec3::Zero());
  pad_forces(workspace, solution.pad_forces);
  solution.converged = ending == Ending::converged;
  solution.trouble = ending == Ending::converged ? ""
                     : ending == Ending::stalled ? describe_trouble("no progress", solution, load)
                                                 : describe_trouble("not converged", solution, load);
  return ending;
}

}  // namespace

StaticSolution solve_static(const Scene& scene, std::span<const PadInput> pads, const StaticOptions& options,
                            const std::function<void(const StaticIteration&)>& watch) {
  // Where an element stiffens beyond its weight, ADMM with fixed weights cycles; heavier weights do not.
  constexpr double kHeaviest = 64.0;
  StaticSolution solution;
  solution.weight_scale = options.weight_scale;
  while (attempt(scene, pads, options, watch, solution) == Ending::stalled &&
         2.0 * solution.weight_scale <= kHeaviest * options.weight_scale)
    solution.weight_scale *= 2.0;
  return solution;
}

}  // namespace tissued::core
