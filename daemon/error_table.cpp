#include "daemon/error_table.hpp"

#include <cmath>

#include "daemon/run_score.hpp"

namespace tissued::daemon {

std::vector<double> ErrorTable::column(std::size_t push) const {
  std::vector<double> values;
  for (const std::vector<double>& row : mm) values.push_back(row[push]);
  return values;
}

std::vector<double> ErrorTable::target_means() const {
  std::vector<double> means;
  for (const std::vector<double>& row : mm) means.push_back(finite_mean(row));
  return means;
}

std::vector<double> ErrorTable::push_means() const {
  std::vector<double> means;
  for (std::size_t push = 0; push < pushes.size(); ++push) means.push_back(finite_mean(column(push)));
  return means;
}

double ErrorTable::mean() const {
  std::vector<double> cells;
  for (const std::vector<double>& row : mm) cells.insert(cells.end(), row.begin(), row.end());
  return finite_mean(cells);
}

double population_std(const std::vector<double>& values) {
  const double mean = finite_mean(values);
  std::vector<double> squares;
  for (const double value : values) squares.push_back((value - mean) * (value - mean));
  return std::sqrt(finite_mean(squares));
}

}  // namespace tissued::daemon
