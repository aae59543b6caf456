#include "daemon/diagnosis_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/diagnosis_words.hpp"
#include "daemon/html.hpp"
#include "daemon/svg_plot.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

constexpr std::size_t kMostPoints = 500;  // of a curve: more than that a panel has no room for
constexpr double kLeastScale = 3.0;       // of bars, in units of the noise: what is noise must not look like much
constexpr double kPanelWidth = 380, kPanelHeight = 250;

const SeriesStyle kAssumed{0, 0}, kParameters{4, 3}, kExplained{1, 0};
// Of forces: what is modelled well lies upon what was measured.
const SeriesStyle kMeasured{7, 0}, kPredicted{1, 1};

// One of the three models, in the order in which they are shown.
struct ShownModel {
  const char* name;
  const char* colour;
  core::Misfit core::Misfits::*misfit;
  SeriesStyle style;
  std::vector<double> core::TrialCourse::*course;
};

const char* explained_name(core::Verdict verdict) {
  switch (verdict) {
    case core::Verdict::missing_physics:
      return "physics modelled";
    case core::Verdict::measurement:
      return "recording corrected";
    default:
      return "as explained";
  }
}

std::array<ShownModel, 3> models(const core::Diagnosis& diagnosis) {
  return {
      {{"as assumed", "var(--c0)", &core::Misfits::assumed, kAssumed, &core::TrialCourse::assumed_mm},
       {"numbers refitted", "var(--c4)", &core::Misfits::parameters, kParameters, &core::TrialCourse::parameters_mm},
       {explained_name(diagnosis.verdict), "var(--c1)", &core::Misfits::explained, kExplained,
        &core::TrialCourse::explained_mm}}};
}

std::string number(double value, int digits) { return std::isfinite(value) ? fixed(value, digits) : "–"; }

// Every so many frames, so that no curve has many more points than there is room for.
std::vector<double> thinned(const std::vector<double>& values) {
  const std::size_t step = std::max<std::size_t>(1, values.size() / kMostPoints);
  std::vector<double> kept;
  for (std::size_t i = 0; i < values.size(); i += step) kept.push_back(values[i]);
  return kept;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) {
    if (std::isfinite(value)) most = std::max(most, value);
  }
  return most;
}

// A curve over the trial's time; none where its frames were not given.
void add_series(LinePlot& plot, const core::TrialCourse& course, const std::vector<double>& values, const char* name,
                const SeriesStyle& style) {
  if (values.empty() || values.size() != course.time.size()) return;
  plot.series.push_back({name, style, thinned(course.time), thinned(values)});
}

// time: at least one frame.
LinePlot panel(const core::TrialCourse& course, const char* label, double top) {
  LinePlot plot;
  plot.width = kPanelWidth;
  plot.height = kPanelHeight;
  const double most_load = largest(course.load);
  plot.title = course.name;
  plot.x = {"time, s", course.time.front(), std::max(course.time.back(), course.time.front() + 1e-3)};
  plot.y = {label, 0.0, top};
  if (most_load > 0.0 && course.load.size() == course.time.size()) {
    plot.shade = {"load, up to " + fixed(most_load, 1) + " mm", {}, thinned(course.time), thinned(course.load)};
    for (double& value : plot.shade.y) value *= 0.92 * top / most_load;
  }
  return plot;
}

std::string legend_entry(const SeriesStyle& style, const char* words) {
  return element("li", legend_swatch(style) + words);
}

// Panels of the trials that were fitted, then of those that were held out.
struct Panels {
  std::string fitted, held_out;

  std::string& of(const core::TrialCourse& course) { return course.held_out ? held_out : fitted; }
  bool empty() const { return fitted.empty() && held_out.empty(); }
};

std::string figure(const std::string& legend, const Panels& panels, const std::string& caption) {
  std::string content =
      element("ul", legend + element("li", "<i class=\"load\"></i>load of the pads"), "class=\"legend\"");
  if (!panels.fitted.empty()) content += element("div", panels.fitted, "class=\"panels\"");
  if (!panels.held_out.empty()) {
    content += element("p", "Held out, never fitted:", "class=\"apart\"") +
               element("div", panels.held_out, "class=\"panels\"");
  }
  return element("figure", content + element("figcaption", caption));
}

// tick: share at which a line is drawn across the bar; none where it is not above zero.
std::string bar(const std::string& name, double share, const std::string& colour, const std::string& value,
                double tick = 0.0) {
  const std::string width = fixed(100.0 * std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0), 1);
  std::string track = "<i style=\"width:" + width + "%;background:" + colour + "\"></i>";
  if (tick > 0.0) track += "<i class=\"tick\" style=\"left:" + fixed(100.0 * tick, 1) + "%\"></i>";
  return element("li", element("span", name, "class=\"name\"") + element("span", track, "class=\"track\"") +
                           element("span", value, "class=\"value\""));
}

std::string one_misfit_table(const core::Diagnosis& diagnosis, const core::Misfits& misfits, const char* caption) {
  HtmlTable table({"simulation", "markers, mm", "targets, mm", "forces, N"}, 1);
  for (const ShownModel& model : models(diagnosis)) {
    const core::Misfit& misfit = misfits.*model.misfit;
    table.add_row(
        {element("span", "", std::string("class=\"dot\" style=\"background:") + model.colour + "\"") + model.name,
         number(misfit.marker_mm, 3), number(misfit.target_mm, 3), number(misfit.force_N, 3)});
  }
  table.add_total({"noise", number(diagnosis.noise_marker_mm, 3), "–", number(diagnosis.noise_force_N, 3)});
  return table.html(caption);
}

}  // namespace

std::string misfit_bars(const core::Diagnosis& diagnosis) {
  const bool held_out = diagnosis.held_out_seen && std::isfinite(diagnosis.held_out.explained.marker_mm);
  const core::Misfits& misfits = held_out ? diagnosis.held_out : diagnosis.trials;
  double most = kLeastScale * diagnosis.noise_marker_mm;
  for (const ShownModel& model : models(diagnosis)) most = std::fmax(most, (misfits.*model.misfit).marker_mm);
  if (!(most > 0.0)) return {};
  std::string bars;
  for (const ShownModel& model : models(diagnosis)) {
    const double misfit = (misfits.*model.misfit).marker_mm;
    bars += bar(model.name, misfit / most, model.colour, number(misfit, 2) + " mm", diagnosis.noise_marker_mm / most);
  }
  return element("div",
                 element("h2", std::string("How far the markers are from the simulation") +
                                   (held_out ? ", in trials that were never fitted" : "")) +
                     element("ul", bars, "class=\"bars\"") +
                     element("p",
                             "Per axis, root mean square. The line is the noise of the tracker, " +
                                 number(diagnosis.noise_marker_mm, 2) + " mm.",
                             "class=\"lead\""),
                 "class=\"card\"");
}

std::string misfit_courses(const core::Diagnosis& diagnosis) {
  double top = 0.0;
  for (const core::TrialCourse& course : diagnosis.courses) {
    for (const ShownModel& model : models(diagnosis)) top = std::max(top, largest(course.*model.course));
  }
  top = round_up(1.05 * std::fmax(top, 2.0 * diagnosis.noise_marker_mm));
  Panels panels;
  std::string legend;
  for (const core::TrialCourse& course : diagnosis.courses) {
    if (course.time.empty()) continue;
    LinePlot plot = panel(course, "marker misfit, mm", top);
    for (const ShownModel& model : models(diagnosis))
      add_series(plot, course, course.*model.course, model.name, model.style);
    plot.levels = {diagnosis.noise_marker_mm};
    panels.of(course) += svg(plot);
  }
  if (panels.empty()) return {};
  for (const ShownModel& model : models(diagnosis)) legend += legend_entry(model.style, model.name);
  legend += element("li", "<i class=\"level\"></i>noise of the tracker");
  return figure(
      legend, panels,
      "Root mean square per axis over the markers that were seen in a frame; all panels have one scale. Lines "
      "stop where no marker was seen.");
}

std::string force_courses(const core::Diagnosis& diagnosis) {
  double top = 0.0;
  for (const core::TrialCourse& course : diagnosis.courses) {
    top = std::max(
        {top, largest(course.force_seen_N), largest(course.force_assumed_N), largest(course.force_explained_N)});
  }
  Panels panels;
  const char* explained = explained_name(diagnosis.verdict);
  for (const core::TrialCourse& course : diagnosis.courses) {
    if (course.time.empty() || course.force_seen_N.empty()) continue;
    LinePlot plot = panel(course, "pad force, N", round_up(1.05 * top));
    add_series(plot, course, course.force_seen_N, "measured", kMeasured);
    add_series(plot, course, course.force_assumed_N, "as assumed", kAssumed);
    add_series(plot, course, course.force_explained_N, explained, kPredicted);
    panels.of(course) += svg(plot);
  }
  if (panels.empty()) return {};
  return figure(
      legend_entry(kMeasured, "measured") + legend_entry(kAssumed, "as assumed") + legend_entry(kPredicted, explained),
      panels, "The largest force of any pad on the tissue.");
}

std::string misfit_table(const core::Diagnosis& diagnosis) {
  std::string tables = one_misfit_table(diagnosis, diagnosis.trials, "Trials that were fitted");
  if (diagnosis.held_out_seen) {
    tables += one_misfit_table(diagnosis, diagnosis.held_out, "Trials that were held out: predicted, never fitted");
  }
  return element("div", tables, "class=\"pair\"") +
         element("p",
                 "Root mean squares per axis; a dash: not recorded. The simulation's own mesh errs by some " +
                     number(diagnosis.discretisation_marker_mm, 2) + " mm at the markers.",
                 "class=\"lead\"");
}

std::string probability_bars(const core::Diagnosis& diagnosis) {
  std::string bars;
  for (const core::Finding& finding : diagnosis.findings) {
    bars += bar(kind_text(finding.kind), finding.probability, "var(--c1)", percent_text(finding.probability));
  }
  std::vector<core::Alternative> ranked = diagnosis.alternatives;
  std::ranges::stable_sort(ranked, std::ranges::greater{}, &core::Alternative::probability);
  for (const core::Alternative& alternative : ranked) {
    bars += bar(kind_text(alternative.kind), alternative.probability, "var(--muted)",
                percent_text(alternative.probability));
  }
  return bars.empty() ? bars : element("ul", bars, "class=\"bars wide-names\"");
}

std::string number_table(const core::Diagnosis& diagnosis) {
  HtmlTable table({"found", "number", "value ± standard deviation", "unit"}, 2);
  bool any = false;
  for (const core::Finding& finding : diagnosis.findings) {
    for (const core::FindingNumber& found : finding.parameters) {
      std::string name = found.name;
      std::ranges::replace(name, '_', ' ');
      table.add_row({escape_html(finding.kind), escape_html(name), number_text(found),
                     found.unit == "1" ? "" : escape_html(found.unit)});
      any = true;
    }
  }
  return any ? table.html("Coordinates are those of the mesh.") : std::string();
}

}  // namespace tissued::daemon
