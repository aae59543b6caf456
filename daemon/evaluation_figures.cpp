#include "daemon/evaluation_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "daemon/evaluation_summary.hpp"
#include "daemon/html.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

constexpr double kSettled = 0.05;                          // of the way
constexpr double kSmoothing = 0.1;                         // s to either side
constexpr std::array kLeastErrors{0.1, 0.05, 0.02, 0.01};  // mm, where logarithmic axes of errors can begin

std::string figure(const std::string& panels, const std::string& legend, std::string_view caption) {
  return element("figure", legend + element("div", panels, "class=\"panels\"") + element("figcaption", caption));
}

std::string legend_item(const SeriesStyle& style, const std::string& name) {
  return element("li", legend_swatch(style) + escape_html(name));
}

std::string legend(const std::string& items) { return element("ul", items, "class=\"legend\""); }

std::string legend_of(const BundleEvaluation& bundle, const SetupList& setups) {
  std::string items;
  for (const std::size_t s : setups) items += legend_item(setup_style(bundle, s), setup_name(bundle.setups[s]));
  return legend(items);
}

std::string panel_title(const BundleEvaluation& bundle, std::size_t trial) {
  return bundle.recordings[trial].name() + ": " + pushes_text(bundle, trial) + " mm";
}

core::Vec3 mean_measured_in_hold(const Recording& recording, std::size_t target) {
  core::Vec3 sum = core::Vec3::Zero();
  double count = 0.0;
  for (const std::size_t frame : recording.hold()) {
    if (const auto measured = recording.target(frame, target)) {
      sum += *measured;
      count += 1.0;
    }
  }
  return sum / count;  // NaN where it was never measured
}

// From the last frame before the jump on, which is iteration 0.
LineSeries jump_series(const BundleEvaluation& bundle, std::size_t setup, std::size_t trial) {
  LineSeries series{setup_name(bundle.setups[setup]), setup_style(bundle, setup), {}, {}};
  const EvaluatedRun& run = bundle.runs[setup][trial];
  const core::Vec3 measured = mean_measured_in_hold(bundle.recordings[trial], 0);
  int iteration = 0;
  for (std::size_t i = run.jump_begin - 1; i < run.jump.size(); ++i) {
    if (i >= run.jump_begin) iteration += run.jump[i].iterations;
    series.x.push_back(iteration);
    series.y.push_back((run.jump[i].targets.front().position - measured).norm());
  }
  return series;
}

// The error's vector is averaged over a fifth of a second, so that the sensor's noise does not hide it.
LineSeries course_series(const BundleEvaluation& bundle, std::size_t setup, std::size_t trial) {
  LineSeries series{setup_name(bundle.setups[setup]), setup_style(bundle, setup), {}, {}};
  const TrialRun& run = bundle.runs[setup][trial].recorded;
  const auto reach = std::lround(kSmoothing * bundle.recordings[trial].rate_hz());
  for (long i = 0; i < std::ssize(run); ++i) {
    core::Vec3 sum = core::Vec3::Zero();
    int count = 0;
    for (long j = std::max(i - reach, 0L); j <= std::min(i + reach, std::ssize(run) - 1); ++j) {
      const TargetSample& sample = run[static_cast<std::size_t>(j)].targets.front();
      if (!sample.measured) continue;
      sum += sample.error();
      ++count;
    }
    series.x.push_back(run[static_cast<std::size_t>(i)].time);
    series.y.push_back((sum / count).norm());
  }
  return series;
}

LineSeries coverage_series(const BundleEvaluation& bundle, std::size_t setup, bool with_sensor) {
  std::vector<double> confidences;  // of the ellipsoid on which a measurement lies
  for (const EvaluatedRun& run : bundle.runs[setup]) {
    const NormalizedSquares squares = normalized_squares(bundle.bundle, run.recorded);
    for (const double square : with_sensor ? squares.with_sensor : squares.claimed) {
      confidences.push_back(chi_square_3(square));
    }
  }
  std::ranges::sort(confidences);
  LineSeries series{setup_name(bundle.setups[setup]), setup_style(bundle, setup), {}, {}};
  for (int percent = 0; percent <= 100; percent += 2) {
    const auto inside = std::ranges::upper_bound(confidences, 0.01 * percent) - confidences.begin();
    series.x.push_back(percent);
    series.y.push_back(100.0 * static_cast<double>(inside) / static_cast<double>(confidences.size()));
  }
  return series;
}

double largest(const std::vector<LineSeries>& series, std::vector<double> LineSeries::*values) {
  double most = 0.0;
  for (const LineSeries& s : series) {
    for (const double value : s.*values) {
      if (std::isfinite(value)) most = std::max(most, value);
    }
  }
  return most;
}

// Errors that are smaller still lie on the edge.
double axis_begin(const std::vector<LineSeries>& series) {
  double least = kLeastErrors.front();
  for (const LineSeries& s : series) {
    for (const double value : s.y) least = std::fmin(least, value);
  }
  const auto begin = std::ranges::find_if(kLeastErrors, [least](double candidate) { return candidate <= least; });
  return begin != kLeastErrors.end() ? *begin : kLeastErrors.back();
}

DotPlot trial_plot(const BundleEvaluation& bundle, const SetupList& setups, const std::string& title,
                   double (*value)(const RunScore&)) {
  DotPlot plot;
  plot.title = title;
  for (const Recording& recording : bundle.recordings) plot.categories.push_back(recording.name());
  double most = 0.0;
  for (const std::size_t s : setups) {
    DotSeries series{setup_name(bundle.setups[s]), setup_style(bundle, s), {}};
    for (const EvaluatedRun& run : bundle.runs[s]) {
      series.values.push_back(value(run.score));
      if (std::isfinite(series.values.back())) most = std::max(most, series.values.back());
    }
    plot.series.push_back(std::move(series));
  }
  plot.y = {"error in the hold, mm", 0.0, round_up(1.05 * most)};
  return plot;
}

double first_hold(const RunScore& score) { return score.targets.front().hold_mm; }

double mean_hold(const RunScore& score) {
  std::vector<double> holds;
  for (const TargetScore& target : score.targets) holds.push_back(target.hold_mm);
  return finite_mean(holds);
}

}  // namespace

SetupList all_setups(const BundleEvaluation& bundle) {
  SetupList setups;
  for (std::size_t s = 0; s < bundle.setups.size(); ++s) setups.push_back(s);
  return setups;
}

SetupList closed_loop_setups(const BundleEvaluation& bundle) {
  SetupList setups = all_setups(bundle);
  std::erase_if(setups, [&](std::size_t s) { return !bundle.setups[s].closed_loop(); });
  return setups;
}

SetupList best_seen_setups(const BundleEvaluation& bundle) {
  SetupList setups = all_setups(bundle);
  std::erase_if(setups, [&](std::size_t s) {
    return std::ranges::any_of(all_setups(bundle), [&](std::size_t other) {
      const bool same_model = bundle.setups[s].model.name == bundle.setups[other].model.name;
      const std::size_t ours = bundle.setup_markers(s), theirs = bundle.setup_markers(other);
      return same_model && (theirs > ours || (theirs == ours && other < s));
    });
  });
  return setups;
}

std::string setup_name(const Setup& setup) {
  return setup.closed_loop() ? setup.model.name + ", " + setup.marker_set : setup.model.name;
}

// One colour per model, one dash per marker set, both in the order in which they were asked for.
SeriesStyle setup_style(const BundleEvaluation& bundle, std::size_t setup) {
  SeriesStyle style;
  for (std::size_t s = 1; s <= setup; ++s) {
    const bool same_model = bundle.setups[s].model.name == bundle.setups[s - 1].model.name;
    style.colour += same_model ? 0 : 1;
    style.dash = same_model ? style.dash + 1 : 0;
  }
  return style;
}

std::string pushes_text(const BundleEvaluation& bundle, std::size_t recording) {
  std::string text;
  for (const PadPush& push : bundle.recordings[recording].pushes()) {
    text += (text.empty() ? "" : ", ") + bundle.bundle.scene.pads[push.pad].name + " by " + fixed(push.largest_mm, 0);
  }
  return text;
}

std::string jump_figure(const BundleEvaluation& bundle, const SetupList& setups, std::string_view caption) {
  std::string panels;
  for (const std::size_t trial : bundle.jump_trials) {
    LinePlot plot;
    plot.title = panel_title(bundle, trial);
    for (const std::size_t s : setups) plot.series.push_back(jump_series(bundle, s, trial));
    const std::string target = bundle.bundle.scene.targets.front().name;
    plot.x = {"ADMM iterations after the jump", 0.0, largest(plot.series, &LineSeries::x)};
    plot.y = {"error of " + target + ", mm (log)", axis_begin(plot.series),
              std::max(round_up(largest(plot.series, &LineSeries::y)), 1.0), true};
    panels += svg(plot);
  }
  return figure(panels, legend_of(bundle, setups), caption);
}

std::string course_figure(const BundleEvaluation& bundle, const SetupList& setups, std::string_view caption) {
  std::string panels;
  for (const std::size_t trial : bundle.jump_trials) {
    LinePlot plot;
    plot.title = panel_title(bundle, trial);
    for (const std::size_t s : setups) plot.series.push_back(course_series(bundle, s, trial));
    const std::string target = bundle.bundle.scene.targets.front().name;
    plot.x = {"time, s", 0.0, largest(plot.series, &LineSeries::x)};
    plot.y = {"error of " + target + ", mm", 0.0, round_up(1.02 * largest(plot.series, &LineSeries::y))};
    panels += svg(plot);
  }
  return figure(panels, legend_of(bundle, setups), caption);
}

std::string trial_figure(const BundleEvaluation& bundle, const SetupList& setups,
                         const std::vector<ReferenceLine>& references, std::string_view caption) {
  const std::string first = bundle.bundle.scene.targets.front().name;
  DotPlot plot = trial_plot(bundle, setups, "Target " + first, first_hold);
  plot.references = references;
  for (const ReferenceLine& reference : references)
    plot.y.high = std::max(plot.y.high, round_up(1.05 * reference.value));
  std::string panels = svg(plot);
  const std::size_t targets = bundle.bundle.scene.targets.size();
  if (targets > 1) {
    panels += svg(trial_plot(bundle, setups, "Mean over all " + std::to_string(targets) + " targets", mean_hold));
  }
  return element("div", figure(panels, legend_of(bundle, setups), caption), "class=\"wide\"");
}

std::string coverage_figure(const BundleEvaluation& bundle, const SetupList& setups, std::string_view caption) {
  std::string panels;
  for (const bool with_sensor : {false, true}) {
    LinePlot plot;
    plot.title = with_sensor ? "Widened by the sensor's noise" : "As claimed";
    plot.x = {"confidence of the ellipsoid, %", 0.0, 100.0};
    plot.y = {"measurements inside, %", 0.0, 100.0};
    plot.diagonal = true;
    for (const std::size_t s : setups) plot.series.push_back(coverage_series(bundle, s, with_sensor));
    panels += svg(plot);
  }
  return figure(panels, legend_of(bundle, setups), caption);
}

std::string dot_figure(const DotPlot& plot, std::string_view caption) {
  std::string items;
  for (const DotSeries& series : plot.series) items += legend_item(series.style, series.name);
  return element("div", figure(svg(plot), legend(items), caption), "class=\"wide\"");
}

std::string step_time_figure(const BundleEvaluation& bundle, const SetupList& setups, std::string_view caption) {
  RangePlot plot;
  plot.title = "Time per step: dot at the median, bar to the 99th percentile";
  const double period_ms = 1e3 / bundle.bundle.scene.rate;
  plot.references.push_back({period_ms, "frame period"});
  double least = period_ms, most = period_ms;
  for (const std::size_t s : setups) {
    const SetupSummary summary = summarize(bundle, s);
    plot.rows.push_back(
        {setup_name(bundle.setups[s]), setup_style(bundle, s), summary.step_p50_ms, summary.step_p99_ms});
    least = std::min(least, summary.step_p50_ms);
    most = std::max(most, summary.step_p99_ms);
  }
  plot.x = {"ms per frame (log)", std::max(0.5 * least, 1e-4), 2.0 * most, true};
  return element("div", figure(svg(plot), "", caption), "class=\"wide\"");
}

double iterations_to_settle(const BundleEvaluation& bundle, std::size_t setup) {
  std::vector<double> settled_at;
  for (const std::size_t trial : bundle.jump_trials) {
    const EvaluatedRun& run = bundle.runs[setup][trial];
    const std::size_t tail = std::max<std::size_t>((run.jump.size() - run.jump_begin) / 10, 1);
    core::Vec3 end = core::Vec3::Zero();
    for (std::size_t i = run.jump.size() - tail; i < run.jump.size(); ++i) {
      end += run.jump[i].targets.front().position / static_cast<double>(tail);
    }
    const double way = (run.jump[run.jump_begin - 1].targets.front().position - end).norm();
    int iteration = 0;
    double settled = NAN;
    for (std::size_t i = run.jump_begin; i < run.jump.size(); ++i) {
      iteration += run.jump[i].iterations;
      const bool is_near = (run.jump[i].targets.front().position - end).norm() <= kSettled * way;
      if (!is_near) {
        settled = NAN;
      } else if (std::isnan(settled)) {
        settled = iteration;
      }
    }
    settled_at.push_back(settled);
  }
  return finite_mean(settled_at);
}

double chi_square_3(double value) {
  const double root = std::sqrt(std::max(value, 0.0));
  return std::erf(root / std::numbers::sqrt2) - std::sqrt(2.0 / std::numbers::pi) * root * std::exp(-0.5 * root * root);
}

}  // namespace tissued::daemon
