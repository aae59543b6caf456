#include "core/fem_assembler.hpp"

#include <algorithm>
#include <cmath>

namespace tissued::core {

FemAssembler::FemAssembler(const FemPattern& pattern, const std::vector<std::unique_ptr<FemTerm>>& terms, int threads)
    : pattern_(&pattern), terms_(&terms), threads_(threads) {
  std::vector<std::vector<std::size_t>> of_node(static_cast<std::size_t>(pattern.node_count));
  std::vector<std::vector<Contribution>> of_block(pattern.block_row.size());
  std::size_t energies = 0, residuals = 0, tangents = 0;
  for (const auto& term : terms) {
    slots_.push_back({energies, residuals, tangents});
    for (int e = 0; e < term->entity_count(); ++e) {
      const std::span<const int> nodes = term->nodes_of_entity(e);
      for (std::size_t a = 0; a < nodes.size(); ++a) of_node[nodes[a]].push_back(residuals + 3 * a);
      residuals += 3 * nodes.size();
      if (!term->has_tangent()) continue;
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        for (std::size_t b = 0; b <= a; ++b, tangents += 9) {
          const int row = std::max(nodes[a], nodes[b]), column = std::min(nodes[a], nodes[b]);
          of_block[pattern.block(row, column)].push_back({tangents, nodes[a] < nodes[b]});
        }
      }
    }
    energies += static_cast<std::size_t>(term->entity_count());
    constexpr int kRange = 64;
    const int range = (kRange + term->batch() - 1) / term->batch() * term->batch();
    for (int begin = 0; begin < term->entity_count(); begin += range)
      ranges_.push_back({slots_.size() - 1, begin, std::min(begin + range, term->entity_count())});
  }
  energy_.resize(energies);
  residual_.resize(residuals);
  tangent_.resize(tangents);
  residual_begin_.push_back(0);
  for (const auto& list : of_node) {
    residual_from_.insert(residual_from_.end(), list.begin(), list.end());
    residual_begin_.push_back(residual_from_.size());
  }
  tangent_begin_.push_back(0);
  for (const auto& list : of_block) {
    tangent_from_.insert(tangent_from_.end(), list.begin(), list.end());
    tangent_begin_.push_back(tangent_from_.size());
  }
}

TermInput FemAssembler::input_of(std::size_t term, const Eigen::VectorXd& x, double time_step,
                                 const FemHistory& history) const {
  return {x.data(), time_step, history[term].data(), pads_};
}

// A second thread costs some 50 us to wake; so many numbers are computed in a millisecond.
int FemAssembler::threads_for(std::size_t numbers) const { return numbers > 500000 ? threads_ : 1; }

template <typename Work>
void FemAssembler::for_each_range(int threads, const Work& work) const {
  const int count = static_cast<int>(ranges_.size());
#pragma omp parallel for schedule(dynamic) num_threads(threads) if (threads > 1)
  for (int r = 0; r < count; ++r) work(ranges_[r].term, ranges_[r].begin, ranges_[r].end);
}

double FemAssembler::evaluate(const Eigen::VectorXd& x, double time_step, const FemHistory& history,
                              Eigen::VectorXd& residual, std::vector<double>* values) {
  const int threads = threads_for(values != nullptr ? tangent_.size() : residual_.size());
  for_each_range(threads, [&](std::size_t t, int begin, int end) {
    const FemTerm& term = *(*terms_)[t];
    const bool tangent = values != nullptr && term.has_tangent();
    term.evaluate(begin, end, input_of(t, x, time_step, history),
                  {energy_.data() + slots_[t].energy, residual_.data() + slots_[t].residual,
                   tangent ? tangent_.data() + slots_[t].tangent : nullptr});
  });
  gather_residual(residual);
  if (values != nullptr) gather_tangent(threads, *values);
  double energy = 0.0;
  for (const double part : energy_) energy += part;
  return energy;
}

void FemAssembler::differentiate(int term, int parameter, const Eigen::VectorXd& x, double time_step,
                                 const FemHistory& history, Eigen::VectorXd& residual) {
  std::fill(residual_.begin(), residual_.end(), 0.0);
  const auto chosen = static_cast<std::size_t>(term);
  for_each_range(threads_for(residual_.size()), [&](std::size_t t, int begin, int end) {
    if (t != chosen) return;
    (*terms_)[t]->differentiate(parameter, begin, end, input_of(t, x, time_step, history),
                                residual_.data() + slots_[t].residual);
  });
  gather_residual(residual);
}

void FemAssembler::gather_residual(Eigen::VectorXd& residual) const {
  residual.resize(3 * pattern_->node_count);
  for (int i = 0; i < pattern_->node_count; ++i) {
    double sum[3] = {0.0, 0.0, 0.0};
    for (std::size_t k = residual_begin_[i]; k < residual_begin_[i + 1]; ++k)
      for (int axis = 0; axis < 3; ++axis) sum[axis] += residual_[residual_from_[k] + axis];
    for (int axis = 0; axis < 3; ++axis) residual[3 * i + axis] = sum[axis];
  }
}

void FemAssembler::gather_tangent(int threads, std::vector<double>& values) const {
  values.resize(pattern_->entries());
#pragma omp parallel for schedule(static) num_threads(threads) if (threads > 1)
  for (int j = 0; j < pattern_->node_count; ++j) {
    for (int b = pattern_->block_begin[j]; b < pattern_->block_begin[j + 1]; ++b) {
      double sum[9] = {};
      for (std::size_t k = tangent_begin_[b]; k < tangent_begin_[b + 1]; ++k) {
        const double* from = tangent_.data() + tangent_from_[k].offset;
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) sum[3 * r + c] += tangent_from_[k].transposed ? from[3 * c + r] : from[3 * r + c];
      }
      const bool diagonal = b == pattern_->block_begin[j];
      for (int c = 0; c < 3; ++c) {
        double* to = values.data() + pattern_->entry(j, b, c);
        for (int r = diagonal ? c : 0; r < 3; ++r) *to++ = sum[3 * r + c];
      }
    }
  }
}

FemAssembler::Entity FemAssembler::inverted() const {
  for (std::size_t t = 0; t < slots_.size(); ++t)
    for (int e = 0; e < (*terms_)[t]->entity_count(); ++e)
      if (!std::isfinite(energy_[slots_[t].energy + static_cast<std::size_t>(e)])) return {static_cast<int>(t), e};
  return {};
}

std::span<const double> FemAssembler::residual_of(const Entity& entity) const {
  const std::size_t rows = 3 * static_cast<std::size_t>((*terms_)[entity.term]->nodes_per_entity());
  return {residual_.data() + slots_[entity.term].residual + rows * static_cast<std::size_t>(entity.entity), rows};
}

}  // namespace tissued::core
