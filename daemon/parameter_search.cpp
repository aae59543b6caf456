#include "daemon/parameter_search.hpp"

#include <algorithm>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/compass_search.hpp>
#include <pagmo/algorithms/gaco.hpp>
#include <pagmo/batch_evaluators/member_bfe.hpp>
#include <pagmo/bfe.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>

namespace tissued::daemon {
namespace {

// The objective as pagmo asks for it.
struct BoundedProblem {
  const std::vector<VariedKey>* keys = nullptr;
  const SearchObjective* objective = nullptr;

  pagmo::vector_double fitness(const pagmo::vector_double& x) const { return (*objective)({x}); }

  // xs: points one after the other.
  pagmo::vector_double batch_fitness(const pagmo::vector_double& xs) const {
    std::vector<SearchPoint> points;
    const auto width = static_cast<std::ptrdiff_t>(keys->size());
    for (auto x = xs.begin(); x != xs.end(); x += width) points.emplace_back(x, x + width);
    return (*objective)(points);
  }

  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    std::pair<pagmo::vector_double, pagmo::vector_double> bounds;
    for (const VariedKey& key : *keys) {
      bounds.first.push_back(key.low);
      bounds.second.push_back(key.high);
    }
    return bounds;
  }
};

// pagmo makes an empty problem to ask what it can do.
pagmo::problem problem_of(const std::vector<VariedKey>& keys, const SearchObjective& objective) {
  return pagmo::problem(BoundedProblem{&keys, &objective});
}

SearchResult champion(const pagmo::population& population) {
  return {population.champion_x(), population.champion_f().front()};
}

}  // namespace

SearchResult search_globally(const std::vector<VariedKey>& keys, const SearchObjective& objective,
                             const GlobalSearchOptions& options) {
  const pagmo::bfe at_once{pagmo::member_bfe{}};
  const auto size = static_cast<unsigned>(options.population);
  const auto generations = static_cast<unsigned>(options.generations);
  pagmo::population population(problem_of(keys, objective), at_once, size, options.seed);
  // pagmo's own defaults but for the archive of solutions, which may not be larger than the population.
  constexpr double kLocality = 1.0, kOracle = 0.0, kAccuracy = 0.01, kFocus = 0.0;
  constexpr unsigned kThreshold = 1, kUpdates = 7, kNever = 100000;
  pagmo::gaco colony(generations, size / 2, kLocality, kOracle, kAccuracy, kThreshold, kUpdates, kNever, kNever, kFocus,
                     false, options.seed);
  colony.set_bfe(at_once);
  return champion(pagmo::algorithm(colony).evolve(population));
}

SearchResult search_around(const std::vector<VariedKey>& keys, const SearchPoint& start,
                           const SearchObjective& objective, int evaluations) {
  constexpr unsigned kUnused = 0;
  pagmo::population population(problem_of(keys, objective), 0u, kUnused);
  population.push_back(start);
  constexpr double kFirstStep = 0.25, kLastStep = 1e-3, kReduction = 0.5;
  const pagmo::compass_search compass(static_cast<unsigned>(evaluations), kFirstStep, kLastStep, kReduction);
  return champion(pagmo::algorithm(compass).evolve(population));
}

std::vector<VariedKey> narrowed(std::vector<VariedKey> keys, const SearchPoint& start, double share) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const double half = 0.5 * share * (keys[i].high - keys[i].low);
    keys[i].low = std::max(keys[i].low, start[i] - half);
    keys[i].high = std::min(keys[i].high, start[i] + half);
  }
  return keys;
}

}  // namespace tissued::daemon
