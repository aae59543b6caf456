#include "tests/core/diagnosis/derivative_check.hpp"

#include <catch2/catch.hpp>

namespace tissued::core::testing {

namespace {

RowMatrix values_of(PathSolver& solver, const LoadPath& path) {
  PathAnswer answer;
  REQUIRE(solver.solve(path, 0, {}, answer));
  return answer.values;
}

}  // namespace

void check_derivatives(PathSolver& solver, const LoadPath& path,
                       const std::vector<std::pair<std::string, double>>& numbers, double share, double tolerance) {
  std::vector<PathParameter> parameters;
  for (const auto& [name, value] : numbers) {
    solver.set_parameter(name, value);
    parameters.push_back({name, 1e-5 * value, {}});
  }
  PathAnswer answer;
  REQUIRE(solver.solve(path, 0, parameters, answer));
  for (std::size_t j = 0; j < numbers.size(); ++j) {
    const auto& [name, value] = numbers[j];
    const double step = share * value;
    solver.set_parameter(name, value + step);
    const RowMatrix above = values_of(solver, path);
    solver.set_parameter(name, value - step);
    const RowMatrix below = values_of(solver, path);
    solver.set_parameter(name, value);
    const RowMatrix difference = (above - below) / (2.0 * step);
    INFO(name);
    CHECK(difference.norm() > 0.0);
    CHECK((answer.by_parameter[j] - difference).norm() < tolerance * difference.norm());
  }
}

}  // namespace tissued::core::testing
