#include "daemon/error_table.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "daemon/tagliabue_paper.hpp"

using namespace tissued::daemon;

namespace {

ErrorTable table_of(const tagliabue::LesionErrors& errors) {
  ErrorTable table;
  for (const tagliabue::PushRange& range : tagliabue::kRanges) table.pushes.emplace_back(range.name);
  for (const auto& row : errors) {
    table.targets.emplace_back();
    table.mm.emplace_back(row.begin(), row.end());
  }
  return table;
}

// The margins of a table as they are printed beside its cells.
struct PrintedMargins {
  std::vector<double> target_means, target_stds, push_means, push_stds;
};

void check_margins(const ErrorTable& table, const PrintedMargins& printed) {
  constexpr double kRounding = 0.0011;  // the cells are rounded, too
  const std::vector<double> targets = table.target_means(), pushes = table.push_means();
  for (std::size_t t = 0; t < targets.size(); ++t) {
    CAPTURE(t);
    CHECK(targets[t] == Approx(printed.target_means[t]).margin(kRounding));
    CHECK(population_std(table.mm[t]) == Approx(printed.target_stds[t]).margin(kRounding));
  }
  for (std::size_t p = 0; p < pushes.size(); ++p) {
    CAPTURE(p);
    CHECK(pushes[p] == Approx(printed.push_means[p]).margin(kRounding));
    CHECK(population_std(table.column(p)) == Approx(printed.push_stds[p]).margin(kRounding));
  }
}

}  // namespace

TEST_CASE("Means and deviations of the second paper's Table 3 are those that it prints") {
  check_margins(table_of(tagliabue::kPbd), {{4.626, 5.247, 7.260, 5.558, 3.851, 4.420, 5.945, 6.011, 4.214, 3.641},
                                            {1.190, 2.579, 3.069, 0.325, 1.912, 0.737, 2.998, 0.440, 0.301, 0.627},
                                            {3.891, 4.133, 4.917, 6.274, 6.946},
                                            {1.499, 1.189, 1.207, 2.213, 2.649}});
  check_margins(table_of(tagliabue::kFiniteElements),
                {{3.495, 5.619, 7.132, 4.451, 1.970, 6.383, 7.065, 5.527, 5.465, 2.955},
                 {1.060, 1.255, 2.151, 0.449, 1.041, 0.310, 2.169, 0.871, 0.607, 0.245},
                 {4.315, 4.222, 4.811, 5.826, 6.473},
                 {1.816, 1.557, 1.698, 2.523, 1.805}});
}

TEST_CASE("What was not measured is in no mean, and a mean over nothing is nothing") {
  ErrorTable table{{"T1", "T2"}, {"5 mm", "10 mm"}, {{1.0, NAN}, {3.0, NAN}}};
  CHECK(table.mean() == 2.0);
  CHECK(table.target_means() == std::vector<double>{1.0, 3.0});
  CHECK(table.push_means()[0] == 2.0);
  CHECK(std::isnan(table.push_means()[1]));
  CHECK(std::isnan(population_std(table.column(1))));
  CHECK(population_std({1.0, NAN, 3.0}) == 1.0);
}
