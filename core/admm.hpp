// ADMM projective dynamics: the stages of one step, equations (1) to (10) and (20).
#pragma once

#include <span>
#include <vector>

#include "core/effect_forces.hpp"
#include "core/probe_contact.hpp"

namespace tissued::core {

// What persists from step to step.
struct AdmmState {
  NodeField x;           // (n x 4) mm, x_n
  NodeField x_previous;  // (n x 4) mm, x_{n-1}
  double dt = 0.0;       // s, from x_previous to x
  std::vector<DomainState> domains;

  explicit AdmmState(const Model& model);
  void reset(const Model& model);
};

// What a step needs beside it; everything is sized here, so that a step allocates nothing.
struct AdmmWorkspace {
  NodeField x_tilde;   // (n x 4) mm, equation (2) or (20)
  NodeField external;  // (n x 4) mN
  std::vector<CornerForce> forces;
  std::vector<float> delta;  // (free x 4) mm, in the factor's order
  HeldNodes held;
  std::vector<std::uint8_t> held_groups;    // (groups of the model's holdable nodes)
  std::vector<Mat3> rotations;              // likewise, of what holds them
  std::vector<Eigen::Vector4d> prescribed;  // (held) mm, where the held nodes must be
  std::vector<Eigen::Vector4d> wanted;      // (held) mm, how far they must move
  ProbeContact contact;
  std::vector<float> contact_change;  // (free x 4) mN, then mm, in the factor's order; where there are probes
  int threads;

  AdmmWorkspace(const Model& model, int thread_count);
  std::span<const std::uint8_t> held_pads() const { return std::span(held_groups).first(pads_); }
  // As before the first step: no pad holds.
  void release_pads();

 private:
  std::size_t pads_;
};

// 0: one thread below the size where a second pays, else all there are.
int resolve_threads(int requested, int tets);

// Which pads hold, which push with a force; prescribed positions and x-tilde: (2) where forces act, (20) where poses
// do. pad_limit: mm by which a held node may move in one step; returns by how much the furthest was cut.
double begin_step(const Model& model, const AdmmState& state, AdmmWorkspace& workspace, std::span<const PadInput> pads,
                  double dt, double pad_limit);

// Where probes are in this step, and what they may touch; after begin_step. Without it no probe touches. limit: mm, see
// ProbeMotion. Returns mm by which the furthest tracked probe is ahead of the simulated one.
double begin_contact(const AdmmState& state, AdmmWorkspace& workspace, std::span<const ProbeInput> probes,
                     double limit);

// Local step (10) of all strain domains. deformations: null, or where Dx of every block goes.
LocalStepResult local_stage(const Model& model, AdmmState& state, AdmmWorkspace& workspace,
                            PointDeformation* deformations = nullptr);

// Global step (7) with the held nodes exact and the skin outside of the probes. node_forces: null, or further ones, (n
// x 4) mN. Returns the largest move of a node, mm.
double global_stage(const Model& model, AdmmState& state, AdmmWorkspace& workspace, double dt,
                    const NodeField* node_forces = nullptr);

// What corrected x and x_previous may have pushed tissue through a probe or off it: moves both by the least, in the
// norm of K, that puts the skin back on it.
void restore_contact(const Model& model, AdmmState& state, AdmmWorkspace& workspace);

// N, of every pad that holds on the tissue, into (pads).
void pad_forces(const AdmmWorkspace& workspace, std::span<Vec3> out);

}  // namespace tissued::core
