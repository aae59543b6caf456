#include "core/effect_forces.hpp"

#include <omp.h>

#include <algorithm>
#include <array>

namespace tissued::core {

static_assert(kLanes == kPointLanes);

namespace {

constexpr int kMostHistory = 32;  // doubles that a law keeps of a point

// body(block) for all blocks, the same whatever the number of threads.
template <typename Body>
void for_blocks(int blocks, int threads, const Body& body) {
  if (threads == 1) {
    for (int b = 0; b < blocks; ++b) body(b);
    return;
  }
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int b = 0; b < blocks; ++b) body(b);
}

}  // namespace

EffectForces::EffectForces(const Enrichment& enrichment, const Model& model)
    : enrichment_(&enrichment),
      blocks_(model.blocks().count()),
      deformations_(static_cast<std::size_t>(blocks_)),
      stresses_(static_cast<std::size_t>(blocks_)),
      node_forces_(NodeField::Zero(model.rest().rows(), 4)),
      x_(3 * model.rest().rows()) {
  std::size_t size = 0, residuals = 0, most = 0;
  for (const auto& law : enrichment.laws()) {
    if (law->history_per_point() > kMostHistory) throw ModelError(std::string(law->name()) + " remembers too much");
    law_offset_.push_back(size);
    size += static_cast<std::size_t>(law->history_per_point()) * kLanes * static_cast<std::size_t>(blocks_);
  }
  for (const auto& term : enrichment.terms()) {
    term_offset_.push_back(size);
    size += term->history_size();
    most = std::max(most, term->history_size());
    residuals = std::max(residuals, static_cast<std::size_t>(3 * term->nodes_per_entity() * term->entity_count()));
  }
  history_.resize(size);
  kept_.resize(size);
  residuals_.resize(residuals);
  term_history_.resize(most);
  reset();
}

void EffectForces::reset() {
  std::fill(kept_.begin(), kept_.end(), 0.0);
  restore();
}

void EffectForces::restore() {
  history_ = kept_;
  for (Stress& stress : stresses_) stress = Stress{};
  node_forces_.setZero();
}

std::size_t EffectForces::law_history(std::size_t law, int block) const {
  return law_offset_[law] + static_cast<std::size_t>(block) * kLanes *
                                static_cast<std::size_t>(enrichment_->laws()[law]->history_per_point());
}

PointBatch EffectForces::batch_of(std::size_t law, int block, double dt) const {
  return {block, dt, history_.data() + law_history(law, block)};
}

// A domain carries shares of the moduli, and so of what laws add to either.
void EffectForces::evaluate_block(const Model& model, const DomainState& state, int block, double dt) {
  const DomainBlock& domain = model.blocks().blocks[block];
  const Material& material = model.scene().material;
  const auto& laws = enrichment_->laws();
  Stress& stress = stresses_[block];
  stress = Stress{};
  for (const bool on_volume : {false, true}) {
    PointResponse response{};
    bool any = false;
    for (std::size_t law = 0; law < laws.size(); ++law) {
      if (laws[law]->on_volume() != on_volume) continue;
      laws[law]->add(batch_of(law, block, dt), deformations_[block], false, response);
      any = true;
    }
    if (!any) continue;
    for (int l = 0; l < kLanes; ++l) {
      const double share = on_volume ? domain.bulk_modulus[l] / material.bulk_modulus()
                                     : domain.shear_modulus[l] / material.shear_modulus();
      const double scale = domain.volume[l] * share * state.factor[l];
      for (int k = 0; k < 9; ++k) stress.p[k][l] += scale * response.stress[k][l];
    }
  }
}

void EffectForces::gather(const NodeField& x) {
  for (Eigen::Index i = 0; i < x.rows(); ++i) x_.segment<3>(3 * i) = x.row(i).head<3>().transpose();
}

void EffectForces::add_term(const FemTerm& term, const TermInput& input) {
  term.evaluate(0, term.entity_count(), input, {nullptr, residuals_.data(), nullptr});
  const double* residual = residuals_.data();
  for (int e = 0; e < term.entity_count(); ++e)
    for (int node : term.nodes_of_entity(e)) {
      node_forces_.row(node).head<3>() -= Eigen::Map<const Eigen::RowVector3d>(residual);
      residual += 3;
    }
}

void EffectForces::evaluate(const Model& model, const std::vector<DomainState>& domains, const NodeField& x,
                            std::span<const PadInput> pads, double dt, int threads) {
  if (!enrichment_->laws().empty())
    for_blocks(blocks_, threads, [&](int b) { evaluate_block(model, domains[b], b, dt); });
  if (enrichment_->terms().empty()) return;
  gather(x);
  node_forces_.setZero();
  for (std::size_t k = 0; k < enrichment_->terms().size(); ++k)
    add_term(*enrichment_->terms()[k], {x_.data(), dt, history_.data() + term_offset_[k], pads});
}

void EffectForces::add_stresses(const Model& model, std::vector<CornerForce>& forces, int threads) const {
  if (enrichment_->laws().empty()) return;
  for_blocks(blocks_, threads, [&](int b) {
    const DomainBlock& block = model.blocks().blocks[b];
    const Stress& stress = stresses_[b];
    for (std::int64_t a = 0; a < block.corner_count; ++a) {
      const DomainCorner& corner = model.blocks().corners[static_cast<std::size_t>(block.first_corner + a)];
      CornerForce& force = forces[static_cast<std::size_t>(block.first_corner + a)];
      for (int i = 0; i < 3; ++i)
        for (int l = 0; l < kLanes; ++l)
          force.force[i][l] -= stress.p[3 * i][l] * corner.gradient[0][l] +
                               stress.p[3 * i + 1][l] * corner.gradient[1][l] +
                               stress.p[3 * i + 2][l] * corner.gradient[2][l];
    }
  });
}

void EffectForces::accept(const NodeField& x, std::span<const PadInput> pads, double dt, int threads) {
  const auto& laws = enrichment_->laws();
  for (std::size_t law = 0; law < laws.size(); ++law) {
    const int per_point = laws[law]->history_per_point();
    if (per_point == 0) continue;
    for_blocks(blocks_, threads, [&](int b) {
      alignas(64) std::array<double, kMostHistory * kLanes> next;
      laws[law]->accept(batch_of(law, b, dt), deformations_[b], next.data());
      std::copy_n(next.begin(), per_point * kLanes,
                  history_.begin() + static_cast<std::ptrdiff_t>(law_history(law, b)));
    });
  }
  for (std::size_t k = 0; k < enrichment_->terms().size(); ++k) {
    const FemTerm& term = *enrichment_->terms()[k];
    if (term.history_size() == 0) continue;
    gather(x);
    double* history = history_.data() + term_offset_[k];
    term.accept({x_.data(), dt, history, pads}, term_history_.data());
    std::copy_n(term_history_.begin(), term.history_size(), history);
  }
}

void EffectForces::add_pad_forces(std::span<const PadInput> pads, std::span<Vec3> forces) const {
  for (const auto& term : enrichment_->terms()) term->add_pad_forces({x_.data(), 0.0, nullptr, pads}, forces);
}

}  // namespace tissued::core
