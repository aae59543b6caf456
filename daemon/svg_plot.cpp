#include "daemon/svg_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>

#include "daemon/html.hpp"

namespace tissued::daemon {
namespace {

constexpr std::array<const char*, SeriesStyle::kDashes> kDashArrays{"", "6 3", "2 3", "9 3 2 3"};
constexpr double kMarkRadius = 4.0;
constexpr double kReferenceMargin = 160;  // px, for the labels of reference lines

// Numbers in SVG need no more than a tenth of a pixel.
std::string px(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.1f", value);
  return buffer;
}

std::string tick_text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

std::string colour(const SeriesStyle& style) {
  return "var(--c" + std::to_string(style.colour % SeriesStyle::kColours) + ")";
}

// Where the data go within the drawing, and where a value lies.
struct Frame {
  double left, top, right, bottom;  // px
  PlotAxis x, y;

  static double share(const PlotAxis& axis, double value) {
    if (!axis.logarithmic) return (value - axis.low) / (axis.high - axis.low);
    return std::log(std::max(value, axis.low) / axis.low) / std::log(axis.high / axis.low);
  }
  double at_x(double value) const { return left + share(x, value) * (right - left); }
  double at_y(double value) const { return bottom - share(y, value) * (bottom - top); }
};

std::string line(double x1, double y1, double x2, double y2, const std::string& kind) {
  return "<line class=\"" + kind + "\" x1=\"" + px(x1) + "\" y1=\"" + px(y1) + "\" x2=\"" + px(x2) + "\" y2=\"" +
         px(y2) + "\"/>\n";
}

std::string text(double x, double y, const std::string& content, const std::string& kind,
                 const std::string& more = {}) {
  return "<text class=\"" + kind + "\" x=\"" + px(x) + "\" y=\"" + px(y) + "\"" + more + ">" + escape_html(content) +
         "</text>\n";
}

std::string y_axis(const Frame& frame, int about) {
  std::string out;
  for (const double tick : axis_ticks(frame.y, about)) {
    const double y = frame.at_y(tick);
    out += line(frame.left, y, frame.right, y, "grid");
    out += text(frame.left - 6, y + 4, tick_text(tick), "tick end");
  }
  const double middle = 0.5 * (frame.top + frame.bottom);
  out += text(14, middle, frame.y.label, "label middle", " transform=\"rotate(-90 14 " + px(middle) + ")\"");
  return out;
}

std::string x_axis(const Frame& frame, int about) {
  std::string out;
  for (const double tick : axis_ticks(frame.x, about)) {
    const double x = frame.at_x(tick);
    out += line(x, frame.top, x, frame.bottom, "grid");
    out += text(x, frame.bottom + 17, tick_text(tick), "tick middle");
  }
  out += text(0.5 * (frame.left + frame.right), frame.bottom + 36, frame.x.label, "label middle");
  return out;
}

// Rising values moved as little as one pass down and one up need to be `apart` from each other and not above `most`.
void spread(std::vector<double>& values, double apart, double most) {
  for (std::size_t i = 1; i < values.size(); ++i) values[i] = std::max(values[i], values[i - 1] + apart);
  for (std::size_t i = values.size(); i-- > 0;) {
    values[i] = std::min(values[i], most);
    most = values[i] - apart;
  }
}

// Labels stand to the right of the plot, where no series is, and beside each other where lines lie close together.
std::string across(const Frame& frame, std::vector<ReferenceLine> references) {
  constexpr double kLabelHeight = 12.0;  // px
  std::erase_if(references, [&](const ReferenceLine& reference) {
    return !(reference.value >= frame.y.low && reference.value <= frame.y.high);
  });
  std::ranges::stable_sort(references, std::greater(), &ReferenceLine::value);
  std::vector<double> labels;
  for (const ReferenceLine& reference : references) labels.push_back(frame.at_y(reference.value) + 4);
  spread(labels, kLabelHeight, frame.bottom + 4);
  std::string out;
  for (std::size_t i = 0; i < references.size(); ++i) {
    const double y = frame.at_y(references[i].value);
    out += line(frame.left, y, frame.right, y, "reference");
    out += text(frame.right + 5, labels[i], references[i].label, "tick");
  }
  return out;
}

std::string mark(double x, double y, const SeriesStyle& style, const std::string& name) {
  constexpr double r = kMarkRadius;
  const bool filled = style.dash % SeriesStyle::kDashes == 0;
  const std::string look = " style=\"stroke:" + colour(style) + ";fill:" + (filled ? colour(style) : "var(--bg)") +
                           "\">" + (name.empty() ? "" : "<title>" + escape_html(name) + "</title>");
  const auto polygon = [&](const std::array<std::array<double, 2>, 4>& corners) {
    std::string points;
    for (const auto& [dx, dy] : corners) points += px(x + dx * r) + "," + px(y + dy * r) + " ";
    return "<polygon class=\"mark\" points=\"" + points + "\"" + look + "</polygon>\n";
  };
  switch (style.dash % SeriesStyle::kDashes) {
    case 1:
      return polygon({{{0, -1.2}, {1.2, 0}, {0, 1.2}, {-1.2, 0}}});
    case 2:
      return polygon({{{-0.9, -0.9}, {0.9, -0.9}, {0.9, 0.9}, {-0.9, 0.9}}});
    case 3:
      return polygon({{{0, -1.1}, {1.1, 0.9}, {-1.1, 0.9}, {0, -1.1}}});
    default:
      return "<circle class=\"mark\" cx=\"" + px(x) + "\" cy=\"" + px(y) + "\" r=\"" + px(r) + "\"" + look +
             "</circle>\n";
  }
}

// From the plot's lower edge up to the curve; what is not finite counts as that edge.
std::string area(const Frame& frame, const LineSeries& shade) {
  if (shade.x.empty()) return {};
  std::string points = px(frame.at_x(shade.x.front())) + "," + px(frame.bottom) + " ";
  for (std::size_t i = 0; i < shade.x.size(); ++i) {
    const double y = std::isfinite(shade.y[i]) ? std::clamp(shade.y[i], frame.y.low, frame.y.high) : frame.y.low;
    points += px(frame.at_x(shade.x[i])) + "," + px(frame.at_y(y)) + " ";
  }
  points += px(frame.at_x(shade.x.back())) + "," + px(frame.bottom);
  return "<polygon class=\"area\" points=\"" + points + "\"><title>" + escape_html(shade.name) + "</title></polygon>\n";
}

// One polyline for every stretch of finite points.
std::string polylines(const Frame& frame, const LineSeries& series) {
  std::string out, points;
  const auto finish = [&] {
    if (!points.empty()) {
      const std::string dash = kDashArrays[series.style.dash % SeriesStyle::kDashes];
      out += "<polyline class=\"series\" style=\"stroke:" + colour(series.style) +
             (dash.empty() ? "" : ";stroke-dasharray:" + dash) + "\" points=\"" + points + "\"><title>" +
             escape_html(series.name) + "</title></polyline>\n";
    }
    points.clear();
  };
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) {
      finish();
      continue;
    }
    const double y = std::clamp(series.y[i], frame.y.low, frame.y.high);
    points += px(frame.at_x(series.x[i])) + "," + px(frame.at_y(y)) + " ";
  }
  finish();
  return out;
}

std::string drawing(double width, double height, const std::string& title, const std::string& content) {
  return "<svg viewBox=\"0 0 " + px(width) + " " + px(height) + "\" role=\"img\" aria-label=\"" + escape_html(title) +
         "\">\n" + text(width / 2, 16, title, "title middle") + content + "</svg>\n";
}

}  // namespace

double round_up(double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0}) {
    if (value <= step * power * (1.0 + 1e-9)) return step * power;
  }
  return 10.0 * power;
}

std::vector<double> axis_ticks(const PlotAxis& axis, int about) {
  std::vector<double> ticks;
  if (axis.logarithmic) {
    for (double power = std::pow(10.0, std::floor(std::log10(axis.low))); power <= axis.high; power *= 10.0) {
      for (const double step : {1.0, 2.0, 5.0}) {
        const double tick = step * power;
        if (tick >= axis.low * (1.0 - 1e-9) && tick <= axis.high * (1.0 + 1e-9)) ticks.push_back(tick);
      }
    }
    return ticks;
  }
  const double rough = (axis.high - axis.low) / about;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double candidate : {5.0, 2.0, 1.0}) {
    if (candidate * power >= rough * (1.0 - 1e-9)) step = candidate * power;
  }
  const auto first = static_cast<long>(std::ceil(axis.low / step - 1e-9));
  const auto last = static_cast<long>(std::floor(axis.high / step + 1e-9));
  for (long i = first; i <= last; ++i) ticks.push_back(static_cast<double>(i) * step);
  return ticks;
}

std::string svg(const LinePlot& plot) {
  const Frame frame{56, 28, plot.width - 14, plot.height - 46, plot.x, plot.y};
  std::string out = area(frame, plot.shade) + y_axis(frame, 6) + x_axis(frame, 6);
  if (plot.diagonal) {
    const double low = std::max(plot.x.low, plot.y.low), high = std::min(plot.x.high, plot.y.high);
    out += line(frame.at_x(low), frame.at_y(low), frame.at_x(high), frame.at_y(high), "reference");
  }
  for (const LineSeries& series : plot.series) out += polylines(frame, series);
  for (const double level : plot.levels) {
    if (level >= plot.y.low && level <= plot.y.high) {
      out += line(frame.left, frame.at_y(level), frame.right, frame.at_y(level), "reference");
    }
  }
  return drawing(plot.width, plot.height, plot.title, out);
}

std::string svg(const DotPlot& plot) {
  constexpr double kWidth = 1080, kHeight = 330;
  const auto count = static_cast<double>(plot.categories.size());
  PlotAxis categories;
  categories.high = count;
  const double right = kWidth - (plot.references.empty() ? 14 : kReferenceMargin);
  const Frame frame{56, 28, right, kHeight - 32, categories, plot.y};
  std::string out = y_axis(frame, 6);
  // Beside one another within nine tenths of a category, in the order of the legend.
  const double spacing = std::min(0.9 / static_cast<double>(std::max<std::size_t>(plot.series.size(), 1)), 0.16);
  const auto place = [&](std::size_t category, std::size_t series) {
    const double offset = (static_cast<double>(series) - 0.5 * static_cast<double>(plot.series.size() - 1)) * spacing;
    return frame.at_x(static_cast<double>(category) + 0.5 + offset);
  };
  for (std::size_t c = 0; c < plot.categories.size(); ++c) {
    if (c > 0)
      out +=
          line(frame.at_x(static_cast<double>(c)), frame.top, frame.at_x(static_cast<double>(c)), frame.bottom, "grid");
    out += text(frame.at_x(static_cast<double>(c) + 0.5), frame.bottom + 18, plot.categories[c], "tick middle");
  }
  out += across(frame, plot.references);
  for (std::size_t s = 0; s < plot.series.size(); ++s) {
    const DotSeries& series = plot.series[s];
    for (std::size_t c = 0; c < plot.categories.size(); ++c) {
      const double value = series.values[c];
      if (!std::isfinite(value)) continue;
      const std::string name =
          series.name + ", " + plot.categories[c] + ": " + tick_text(std::round(value * 1e3) / 1e3);
      out += mark(place(c, s), frame.at_y(std::min(value, plot.y.high)), series.style, name);
    }
  }
  return drawing(kWidth, kHeight, plot.title, out);
}

std::string svg(const RangePlot& plot) {
  constexpr double kWidth = 1080, kRow = 26, kLabel = 200;
  const double height = 40 + kRow * static_cast<double>(plot.rows.size()) + 46;
  const Frame frame{kLabel, 40, kWidth - 14, height - 46, plot.x, PlotAxis{}};
  std::string out = x_axis(frame, 8);
  for (const ReferenceLine& reference : plot.references) {
    if (reference.value < plot.x.low || reference.value > plot.x.high) continue;
    const double x = frame.at_x(reference.value);
    out += line(x, frame.top, x, frame.bottom, "reference");
    out += text(x, frame.top - 4, reference.label, "tick middle");
  }
  for (std::size_t i = 0; i < plot.rows.size(); ++i) {
    const RangeRow& row = plot.rows[i];
    const double y = frame.top + kRow * (static_cast<double>(i) + 0.5);
    out += text(kLabel - 8, y + 4, row.name, "tick end");
    if (!std::isfinite(row.low) || !std::isfinite(row.high)) continue;
    const double from = frame.at_x(row.low), to = frame.at_x(row.high);
    const std::string look = "\" style=\"stroke:" + colour(row.style);
    out += line(from, y, to, y, "series" + look) + line(to, y - 6, to, y + 6, "series" + look);
    out += mark(from, y, row.style, row.name + ": " + tick_text(row.low) + " to " + tick_text(row.high));
  }
  return drawing(kWidth, height, plot.title, out);
}

std::string legend_swatch(const SeriesStyle& style) {
  const Frame frame{0, 0, 34, 12, PlotAxis{}, PlotAxis{}};
  return "<svg class=\"swatch\" viewBox=\"0 0 34 12\" width=\"34\" height=\"12\" aria-hidden=\"true\">" +
         polylines(frame, {"", style, {0.0, 1.0}, {0.5, 0.5}}) + mark(17, 6, style, "") + "</svg>";
}

}  // namespace tissued::daemon
