#include "daemon/calibration_page.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/html.hpp"
#include "daemon/page_style.hpp"
#include "daemon/svg_plot.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

// Every value, and behind it the best so far. What the configuration refused is left out.
struct Course {
  std::vector<double> evaluation, value, best;
};

Course course_of(const std::vector<SearchResult>& evaluated, std::size_t distances) {
  Course course;
  double best = NAN;
  for (std::size_t i = 0; i < evaluated.size(); ++i) {
    const bool refused = evaluated[i].value >= Calibration::kRefused;
    const double value = refused ? NAN : evaluated[i].value / static_cast<double>(distances);
    best = std::fmin(best, value);
    course.evaluation.push_back(static_cast<double>(i + 1));
    course.value.push_back(value);
    course.best.push_back(best);
  }
  return course;
}

std::string error_plot(const std::vector<SearchResult>& evaluated, std::size_t distances) {
  const Course course = course_of(evaluated, distances);
  double most = 0.0;
  for (const double value : course.value) most = std::fmax(most, value);
  LinePlot plot;
  plot.title = "Mean error, mm, by evaluation: every point, and the best so far";
  plot.series = {{"every point", {0, 2}, course.evaluation, course.value},
                 {"best so far", {1, 0}, course.evaluation, course.best}};
  plot.x = {"evaluation", 0.0, static_cast<double>(evaluated.size())};
  plot.y = {"mean error, mm", 0.0, round_up(1.02 * most)};
  return svg(plot);
}

std::string number_plot(const std::vector<SearchResult>& evaluated, const VariedKey& key, std::size_t number) {
  LineSeries tried{"every point", {0, 2}, {}, {}}, best{"best so far", {1, 0}, {}, {}};
  double least = INFINITY;
  for (std::size_t i = 0; i < evaluated.size(); ++i) {
    const bool better = evaluated[i].value < least;
    least = std::min(least, evaluated[i].value);
    for (LineSeries* series : {&tried, &best}) series->x.push_back(static_cast<double>(i + 1));
    tried.y.push_back(evaluated[i].point[number]);
    best.y.push_back(better ? evaluated[i].point[number] : best.y.empty() ? NAN : best.y.back());
  }
  LinePlot plot;
  plot.title = key.key;
  plot.series = {tried, best};
  plot.x = {"evaluation", 0.0, static_cast<double>(evaluated.size())};
  plot.y = {key.key.substr(key.key.rfind('.') + 1), key.low, key.high};
  return svg(plot);
}

std::string result_table(const std::vector<VariedKey>& bounds, const SearchPoint& start, const SearchResult& best) {
  std::vector<std::string> headings{"key", "from", "to"};
  if (!start.empty()) headings.emplace_back("start");
  headings.emplace_back("found");
  HtmlTable table(headings, 1);
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    std::vector<std::string> row{element("code", escape_html(bounds[i].key)), fixed(bounds[i].low, 4),
                                 fixed(bounds[i].high, 4)};
    if (!start.empty()) row.push_back(fixed(start[i], 4));
    row.push_back(element("b", fixed(best.point[i], 4)));
    table.add_row(std::move(row));
  }
  return table.html("Numbers between their bounds, and where the search ended.");
}

std::string list_or_all(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + escape_html(name);
  return text.empty() ? "all" : text;
}

}  // namespace

std::string calibration_page(const CalibrationRequest& request, const std::vector<VariedKey>& bounds,
                             const SearchPoint& start, const std::vector<SearchResult>& evaluated,
                             const SearchResult& best, std::size_t distances) {
  const auto mean = [distances](double sum) { return fixed(sum / static_cast<double>(distances), 4) + " mm"; };
  std::string lead = "<code>" + escape_html(request.model) + "</code> on " + escape_html(request.bundle) +
                     ", targets: " + list_or_all(request.targets) + "; trials: " + list_or_all(request.trials) + ". " +
                     (start.empty() ? "A genetic algorithm" : "Compass search from a configuration") + ", " +
                     std::to_string(evaluated.size()) + " points evaluated: mean error of a target in the hold " +
                     "<b>" + mean(best.value) + "</b>";
  // The first point of fine tuning is its start.
  if (!start.empty()) lead += ", at the start " + mean(evaluated.front().value);
  std::string panels = error_plot(evaluated, distances);
  for (std::size_t i = 0; i < bounds.size(); ++i) panels += number_plot(evaluated, bounds[i], i);
  const std::string figure =
      element("figure", element("div", panels, "class=\"panels\"") +
                            element("figcaption",
                                    "Dotted: every point in the order of evaluation, gaps where the configuration "
                                    "refuses one. Solid: the best so far."));
  return html_page("tissued: calibration", kPageStyle,
                   element("h1", "Numbers that bring a model closest to recordings") +
                       element("p", lead + ".", "class=\"lead\"") +
                       element("div",
                               "This is research software, not a medical device. Nobody has tested it for "
                               "clinical use.",
                               "class=\"notice\" role=\"note\"") +
                       result_table(bounds, start, best) + figure);
}

}  // namespace tissued::daemon
