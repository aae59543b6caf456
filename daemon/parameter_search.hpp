#pragma once

#include <functional>
#include <string>
#include <vector>

namespace tissued::daemon {

/// A number that is searched for, between bounds that are kept.
struct VariedKey {
  std::string key;  ///< of the configuration, dotted
  double low, high;
};

/// One value per varied key.
using SearchPoint = std::vector<double>;

/// The values at several points, which may be worked out beside each other; less is better, all are finite.
using SearchObjective = std::function<std::vector<double>(const std::vector<SearchPoint>&)>;

struct SearchResult {
  SearchPoint point;
  double value;
};

struct GlobalSearchOptions {
  int population = 24;   ///< points that are evaluated at once; at least 8, an odd number is made even
  int generations = 20;  ///< after the first, random one
  unsigned seed = 1;
};

/// The first guess: a genetic algorithm (pagmo's sga: tournament, simulated binary crossover, polynomial mutation, the
/// best of parents and children live on), a generation at a time so that it can be shared out; what was asked for once
/// is not asked for again. The same seed and objective make the same calls.
SearchResult search_globally(const std::vector<VariedKey>& keys, const SearchObjective& objective,
                             const GlobalSearchOptions& options);

/// Fine tuning: compass search (pagmo's compass_search) from `start`, the first step a quarter of the bounds' width,
/// the last a thousandth, one point after the other. Ends early with the round, of two points per key, in which it has
/// evaluated `evaluations`. No chance in it.
SearchResult search_around(const std::vector<VariedKey>& keys, const SearchPoint& start,
                           const SearchObjective& objective, int evaluations);

/// The keys with bounds of `share` of their width, centred at `start`, and no further than they were.
std::vector<VariedKey> narrowed(std::vector<VariedKey> keys, const SearchPoint& start, double share);

}  // namespace tissued::daemon
