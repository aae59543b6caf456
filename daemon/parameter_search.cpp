#include "daemon/parameter_search.hpp"

#include <algorithm>
#include <map>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/compass_search.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <utility>

namespace tissued::daemon {
namespace {

// Values of points, and which were asked for while they were not yet known.
struct Notebook {
  std::map<SearchPoint, double> known;
  std::vector<SearchPoint> wanted;  // each once
};

// pagmo asks for one point after the other. What the notebook does not know is written down there, to be worked out
// with all the others, and gets a value that means nothing.
struct NotedProblem {
  const std::vector<VariedKey>* keys = nullptr;
  Notebook* notebook = nullptr;

  pagmo::vector_double fitness(const pagmo::vector_double& x) const {
    const auto found = notebook->known.find(x);
    if (found != notebook->known.end()) return {found->second};
    if (std::ranges::count(notebook->wanted, x) == 0) notebook->wanted.push_back(x);
    return {0.0};
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

// One point at a time, asked for at once.
struct AskedProblem {
  NotedProblem bounds;
  const SearchObjective* objective = nullptr;

  pagmo::vector_double fitness(const pagmo::vector_double& x) const { return (*objective)({x}); }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const { return bounds.get_bounds(); }
};

// make() as often as it takes until all that it asks for is known; it must do the same every time but for the values.
pagmo::population make_with_known(const std::function<pagmo::population()>& make, const SearchObjective& objective,
                                  Notebook& notebook) {
  for (;;) {
    pagmo::population population = make();
    if (notebook.wanted.empty()) return population;
    const std::vector<SearchPoint> points = std::exchange(notebook.wanted, {});
    const std::vector<double> values = objective(points);
    for (std::size_t i = 0; i < points.size(); ++i) notebook.known[points[i]] = values[i];
  }
}

SearchResult champion(const pagmo::population& population) {
  return {population.champion_x(), population.champion_f().front()};
}

}  // namespace

// A generation's children are bred before any of them is asked for, so that one pass tells which they are and the next
// one selects among them.
SearchResult search_globally(const std::vector<VariedKey>& keys, const SearchObjective& objective,
                             const GlobalSearchOptions& options) {
  constexpr double kCrossover = 0.9, kCrossoverIndex = 10.0, kMutationIndex = 20.0;
  constexpr unsigned kTournament = 2;
  const double mutation = 1.0 / static_cast<double>(keys.size());
  Notebook notebook;
  const pagmo::problem problem(NotedProblem{&keys, &notebook});
  const auto size = static_cast<unsigned>(options.population + options.population % 2);
  pagmo::population population =
      make_with_known([&] { return pagmo::population(problem, size, options.seed); }, objective, notebook);
  for (unsigned generation = 1; generation <= static_cast<unsigned>(options.generations); ++generation) {
    const auto breed = [&] {
      const pagmo::sga genetic(1, kCrossover, kCrossoverIndex, mutation, kMutationIndex, kTournament, "sbx",
                               "polynomial", "tournament", options.seed + generation);
      return genetic.evolve(population);
    };
    population = make_with_known(breed, objective, notebook);
  }
  return champion(population);
}

SearchResult search_around(const std::vector<VariedKey>& keys, const SearchPoint& start,
                           const SearchObjective& objective, int evaluations) {
  constexpr unsigned kUnused = 0;
  pagmo::population population(pagmo::problem(AskedProblem{{&keys, nullptr}, &objective}), 0u, kUnused);
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
