#include "daemon/svg_plot.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string_view>

#include "daemon/html.hpp"

using namespace tissued::daemon;

namespace {

std::size_t count(std::string_view text, std::string_view what) {
  std::size_t found = 0;
  for (auto at = text.find(what); at != std::string_view::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

LinePlot plot_of(std::vector<double> y) {
  LinePlot plot;
  plot.x = {"x", 0, 4};
  plot.y = {"y", 0, 10};
  plot.series.push_back({"s", {}, {0, 1, 2, 3, 4}, std::move(y)});
  return plot;
}

}  // namespace

TEST_CASE("Ticks are round numbers within the axis") {
  CHECK(axis_ticks({"", 0, 10}, 5) == std::vector<double>{0, 2, 4, 6, 8, 10});
  CHECK(axis_ticks({"", 0, 600}, 6) == std::vector<double>{0, 100, 200, 300, 400, 500, 600});
  CHECK(axis_ticks({"", 0.1, 10, true}, 0).size() == 7);  // 0.1 0.2 0.5 1 2 5 10
  const auto small = axis_ticks({"", 0, 0.004}, 4);
  REQUIRE(small.size() == 5);
  CHECK(small[3] == Approx(0.003));
}

TEST_CASE("Axes end on round numbers") {
  CHECK(round_up(3.3) == Approx(4.0));
  CHECK(round_up(0.012) == Approx(0.015));
  CHECK(round_up(95) == Approx(100.0));
  CHECK(round_up(2.0) == Approx(2.0));
  CHECK(round_up(0.0) == 1.0);
  CHECK(round_up(NAN) == 1.0);
}

TEST_CASE("A line is where its numbers are: (0, 0) at the lower left, the largest at the upper right") {
  const std::string text = svg(plot_of({0, 2.5, 5, 7.5, 10}));
  CHECK(count(text, "<polyline") == 1);
  CHECK_THAT(text, Catch::Contains("points=\"56.0,254.0 168.5,197.5 281.0,141.0 393.5,84.5 506.0,28.0 \""));
}

TEST_CASE("What is not finite interrupts a line and is no dot") {
  CHECK(count(svg(plot_of({0, 1, NAN, 3, 4})), "<polyline") == 2);
  CHECK(count(svg(plot_of({NAN, NAN, NAN, NAN, NAN})), "<polyline") == 0);
  DotPlot dots;
  dots.categories = {"a", "b", "c"};
  dots.y = {"y", 0, 2};
  dots.series.push_back({"s", {}, {1.0, NAN, 2.0}});
  CHECK(count(svg(dots), "<circle") == 2);
  CHECK_THAT(svg(dots), !Catch::Contains("nan"));
}

TEST_CASE("A shade lies behind the lines, and levels go across") {
  LinePlot plot = plot_of({0, 1, 2, 3, 4});
  plot.shade = {"load", {}, {0, 2, 4}, {0, 5, NAN}};
  plot.levels = {2.5, 99.0, NAN};
  const std::string text = svg(plot);
  // Along the lower edge, up to half of the height in the middle, and down to the edge where nothing is known.
  CHECK_THAT(text, Catch::Contains("points=\"56.0,254.0 56.0,254.0 281.0,141.0 506.0,254.0 506.0,254.0\""));
  CHECK(text.find("class=\"area\"") < text.find("<polyline"));
  CHECK(count(text, "class=\"reference\"") == 1);
  CHECK_THAT(text, Catch::Contains("class=\"reference\" x1=\"56.0\" y1=\"197.5\" x2=\"506.0\" y2=\"197.5\""));
}

TEST_CASE("A series is told by more than its colour") {
  std::vector<std::string> swatches;
  for (std::size_t dash = 0; dash < SeriesStyle::kDashes; ++dash) swatches.push_back(legend_swatch({0, dash}));
  std::ranges::sort(swatches);
  CHECK(std::ranges::adjacent_find(swatches) == swatches.end());
}

TEST_CASE("Names cannot break out of the page") {
  CHECK(escape_html("<b a=\"1\">&") == "&lt;b a=&quot;1&quot;&gt;&amp;");
  LinePlot plot = plot_of({0, 1, 2, 3, 4});
  plot.title = plot.series[0].name = plot.x.label = "\"><script>";
  CHECK_THAT(svg(plot), !Catch::Contains("<script>"));
}

TEST_CASE("Ranges lie on their axis, and references beyond it are left out") {
  RangePlot plot;
  plot.x = {"ms", 1, 100, true};
  plot.rows = {{"a", {}, 1, 100}, {"b", {}, NAN, NAN}};
  plot.references = {{10, "period"}, {1000, "far"}};
  const std::string text = svg(plot);
  CHECK_THAT(text, Catch::Contains("period") && !Catch::Contains("far"));
  CHECK(count(text, "<circle") == 1);
  // From the left edge to the right one, and the reference half-way: the axis is logarithmic.
  CHECK_THAT(text,
             Catch::Contains("x1=\"200.0\"") && Catch::Contains("x2=\"1066.0\"") && Catch::Contains("x1=\"633.0\""));
}
