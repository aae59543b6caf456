#pragma once

#include <string>
#include <vector>

namespace tissued::daemon {

/// Errors by target (rows) and size of the push (columns), mm; NaN where nothing was measured. Means and standard
/// deviations are over the cells that there are, and the deviations are those of a whole population (divided by n), as
/// in Table 3 of Tagliabue et al. 2019; NaN over no cell.
struct ErrorTable {
  std::vector<std::string> targets;
  std::vector<std::string> pushes;
  std::vector<std::vector<double>> mm;  ///< (targets x pushes)

  std::vector<double> column(std::size_t push) const;
  std::vector<double> target_means() const;
  std::vector<double> push_means() const;
  /// Over every cell.
  double mean() const;
};

/// Of the finite ones among `values`, divided by their number; NaN where there is none.
double population_std(const std::vector<double>& values);

}  // namespace tissued::daemon
