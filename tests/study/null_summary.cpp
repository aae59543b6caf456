#include "tests/study/null_summary.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <functional>
#include <iomanip>
#include <map>
#include <ostream>

namespace tissued::study {

namespace {

void write_share(const std::string& what, const std::vector<NullRow>& rows,
                 const std::function<bool(const NullRow&)>& holds, std::ostream& out) {
  const auto count = static_cast<int>(std::count_if(rows.begin(), rows.end(), holds));
  const auto all = static_cast<int>(rows.size());
  const Interval interval = clopper_pearson(count, all);
  out << std::left << std::setw(44) << what << std::right << std::setw(4) << count << " of " << all << std::fixed
      << std::setprecision(1) << std::setw(7) << 100.0 * count / std::max(1, all) << " %  (" << 100.0 * interval.low
      << " to " << 100.0 * interval.high << ")\n";
}

void write_quantiles(const std::string& what, std::vector<double> values, std::ostream& out) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  std::sort(values.begin(), values.end());
  out << std::left << std::setw(44) << what << std::right << std::setw(5) << values.size();
  for (double share : {0.5, 0.9, 0.95, 0.98, 0.99, 1.0}) {
    if (values.empty()) continue;
    const auto last = static_cast<double>(values.size() - 1);
    out << std::fixed << std::setprecision(3) << std::setw(10)
        << values[static_cast<std::size_t>(std::ceil(share * last))];
  }
  out << '\n';
}

std::vector<double> of_all(const std::vector<NullRow>& rows, const std::function<double(const NullRow&)>& value) {
  std::vector<double> values;
  for (const NullRow& row : rows) values.push_back(value(row));
  return values;
}

double modulus_error(const NullRow& row) {
  return std::abs(std::log(row.number("modulus_fitted_kPa") / row.number("modulus_true_kPa")));
}
double ratio_error(const NullRow& row) { return std::abs(row.number("ratio_fitted") - row.number("ratio_true")); }

bool says(const NullRow& row, const std::string& kind) {
  return (" " + row.text("findings") + " ").find(" " + kind + " ") != std::string::npos;
}

bool numbers_are_right(const NullRow& row) {
  return row.text("modulus_assumed_kPa") == row.text("modulus_true_kPa") &&
         row.text("ratio_assumed") == row.text("ratio_true");
}

std::vector<NullRow> those(const std::vector<NullRow>& rows, const std::function<bool(const NullRow&)>& hold) {
  std::vector<NullRow> out;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(out), hold);
  return out;
}

void write_thresholds(const std::vector<NullRow>& rows, std::ostream& out) {
  const auto with_force = those(rows, [](const NullRow& row) { return row.text("force_seen") == "1"; });
  const auto of = [](const char* column) { return [column](const NullRow& row) { return row.number(column); }; };
  const auto in_sd = [](double error, double sd) { return error / sd; };
  out << "\nquantiles                                    count      50 %      90 %      95 %      98 %      99 %     "
         "100 %\n";
  write_quantiles("advantage of the likeliest kind (kAccept)", of_all(rows, of("advantage")), out);
  write_quantiles("gain of a pair (kAcceptBeside)", of_all(rows, of("pair_gain")), out);
  write_quantiles("structure left (kStructure)", of_all(rows, of("structure")), out);
  write_quantiles("ln E off, forces seen (kModulusOff)", of_all(with_force, modulus_error), out);
  write_quantiles("nu off (kRatioOff)", of_all(rows, ratio_error), out);
  write_quantiles("E off, forces seen, in stated sd",
                  of_all(with_force,
                         [&](const NullRow& row) {
                           return in_sd(modulus_error(row),
                                        row.number("modulus_sd_kPa") / row.number("modulus_fitted_kPa"));
                         }),
                  out);
  write_quantiles("nu off, in stated sd",
                  of_all(rows, [&](const NullRow& row) { return in_sd(ratio_error(row), row.number("ratio_sd")); }),
                  out);
  write_quantiles("seconds of a diagnosis", of_all(rows, of("diagnosis_seconds")), out);
  write_quantiles("seconds of a truth", of_all(rows, of("truth_seconds")), out);
}

}  // namespace

Interval clopper_pearson(int count, int all) {
  using Binomial = boost::math::binomial_distribution<double>;
  if (all == 0) return {};
  return {Binomial::find_lower_bound_on_p(all, count, 0.025), Binomial::find_upper_bound_on_p(all, count, 0.025)};
}

bool is_false_alarm(const NullRow& row) {
  const std::string& verdict = row.text("verdict");
  return verdict == "missing-physics" || verdict == "measurement" || verdict == "unexplained";
}

void summarise(const std::vector<NullRow>& rows, std::ostream& out) {
  const auto right = those(rows, numbers_are_right);
  write_share("false alarms", rows, is_false_alarm, out);
  write_share(
      "failed: no verdict", rows, [](const NullRow& row) { return row.text("verdict") == "failed"; }, out);
  write_share(
      "other numbers said where they are right", right, [](const NullRow& row) { return says(row, "parameters"); },
      out);
  double redraws = 0.0;
  for (const NullRow& row : rows) redraws += row.number("redraws");
  out << "bodies drawn again, without room for a pad or without an equilibrium: " << std::setprecision(0) << redraws
      << '\n';
  for (const NullRow& row : rows)
    if (is_false_alarm(row) || row.text("verdict") == "failed")
      out << "  seed " << row.seed << ": " << row.text("verdict") << " (" << row.text("findings") << "), advantage "
          << row.text("advantage") << ", structure " << row.text("structure") << '\n';
  write_thresholds(rows, out);
}

}  // namespace tissued::study
