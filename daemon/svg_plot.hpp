// Figures as inline SVG. Colours come from the page's style (--c0, --c1, ..., --fg, --muted, --rule), so that light,
// dark and print look right. Labels are plain text; what is not finite is left out.
#pragma once

#include <string>
#include <vector>

namespace tissued::daemon {

/// How a series looks: its colour says the model; dash and mark say the marker set, for who does not see the colour.
struct SeriesStyle {
  static constexpr std::size_t kColours = 8;
  static constexpr std::size_t kDashes = 4;
  std::size_t colour = 0;  ///< modulo kColours
  std::size_t dash = 0;    ///< modulo kDashes; 0: solid line, filled circle
};

struct PlotAxis {
  std::string label;  ///< with its unit
  double low = 0.0;
  double high = 1.0;
  bool logarithmic = false;
};

/// A value that the series are to be compared with, drawn across the plot.
struct ReferenceLine {
  double value;
  std::string label;
};

struct LineSeries {
  std::string name;
  SeriesStyle style;
  std::vector<double> x, y;
};

struct LinePlot {
  std::string title;
  PlotAxis x, y;
  std::vector<LineSeries> series;
  bool diagonal = false;             ///< a line where x = y
  std::vector<double> levels;        ///< values of y, drawn across the plot
  LineSeries shade;                  ///< an area below the curve, behind all else; its style is not asked for
  double width = 520, height = 300;  ///< px
};

struct DotSeries {
  std::string name;
  SeriesStyle style;
  std::vector<double> values;  ///< (categories)
};

struct DotPlot {
  std::string title;
  std::vector<std::string> categories;  ///< along x
  PlotAxis y;
  std::vector<DotSeries> series;
  std::vector<ReferenceLine> references;
};

struct RangeRow {
  std::string name;
  SeriesStyle style;
  double low, high;
};

/// One row per series, a bar from `low` (dot) to `high` (tick).
struct RangePlot {
  std::string title;
  PlotAxis x;
  std::vector<RangeRow> rows;
  std::vector<ReferenceLine> references;  ///< values of x
};

std::string svg(const LinePlot& plot);
std::string svg(const DotPlot& plot);
std::string svg(const RangePlot& plot);

/// A short line with its mark, for legends.
std::string legend_swatch(const SeriesStyle& style);

/// Round numbers from `low` to `high`, some `about` of them; of a logarithmic axis 1, 2 and 5 times powers of ten.
std::vector<double> axis_ticks(const PlotAxis& axis, int about);

/// The next round number at or above `value`, at which an axis can end: 1, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of
/// ten. 1 where value is not above 0.
double round_up(double value);

}  // namespace tissued::daemon
