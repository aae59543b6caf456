#include "daemon/evaluation_page.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "daemon/afshar_comparison.hpp"
#include "daemon/evaluation_figures.hpp"
#include "daemon/evaluation_summary.hpp"
#include "daemon/html.hpp"
#include "daemon/page_style.hpp"
#include "daemon/tagliabue_comparison.hpp"
#include "daemon/text_table.hpp"
#include "daemon/version.hpp"

namespace tissued::daemon {
namespace {

std::string number(double value, int digits) { return std::isfinite(value) ? fixed(value, digits) : "–"; }
std::string percent(double share) { return number(100.0 * share, 1); }

std::string join(const std::vector<std::string>& parts, const char* between) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : between) + part;
  return text;
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &parts);
  return text;
}

std::string model_table(const BundleEvaluation& bundle) {
  HtmlTable table({"model", "simulator", "element", "scheme", "iterations a frame", "keys set"}, 6);
  std::string last;
  for (const Setup& setup : bundle.setups) {
    if (setup.model.name == last) continue;
    last = setup.model.name;
    const core::SimulatorOptions& options = setup.config.simulator;
    std::vector<std::string> row{element("b", escape_html(last)), escape_html(options.kind)};
    if (options.kind == "admm" || options.kind == "kf-admm") {
      row.push_back(options.solver.element == core::Element::p1 ? "p1" : "smoothed");
      row.push_back(options.solver.scheme == core::Scheme::algorithm_1 ? "algorithm-1" : "per-frame");
      row.push_back(std::to_string(options.solver.iterations));
    } else {
      const bool is_fem = options.kind == "fem";
      row.push_back(is_fem ? options.fem.element == core::FemElement::p1 ? "p1" : "p2" : "–");
      row.insert(row.end(), {"–", is_fem ? "to the end" : "–"});
    }
    row.push_back(element("code", escape_html(join(setup.model.overrides, " "))));
    table.add_row(std::move(row));
  }
  return table.html("Models: what of the configuration makes them; everything else is at its default.");
}

std::string how_measured() {
  return element("h3", "How errors are measured") +
         element(
             "p",
             "Recorded frames go through the stages of <code>tissued</code> in this process: none is lost, every "
             "trial begins at rest, and each run has one thread. Targets are never shown to the simulator. "
             "<b>Hold</b>: "
             "distance between the mean answer and the mean measurement while the pads stand still at their largest "
             "push (the first fifth left out), in which the sensor's noise averages out; so "
             "<code>tissuectl play</code> and <code>scripts/table1</code> measure. <b>RMS, p95, max</b>: over every "
             "frame in which the target was measured and a pad touched, the sensor's noise included. "
             "<b>Ellipsoids</b>: the share of measurements inside the 95 % ellipsoid, as the answer claims it, and "
             "widened by the sensor's stated noise, which a measurement has and the tissue has not; 95 would be "
             "honest. <b>NEES</b>: the mean square in units of that covariance; 3 would be honest.");
}

std::string about_bundle(const BundleEvaluation& evaluation) {
  const config::Bundle& bundle = evaluation.bundle;
  const core::TetMesh& mesh = evaluation.setups.front().scene.mesh;
  const core::Material& material = bundle.scene.material;
  std::string text = std::to_string(mesh.node_count()) + " nodes, " + std::to_string(mesh.tet_count()) +
                     " tetrahedra; assumed: E " + fixed(material.youngs_modulus, 1) + " kPa, Poisson's ratio " +
                     fixed(material.poissons_ratio, 3) + "; " + std::to_string(bundle.scene.markers.size()) +
                     " markers (noise " + fixed(bundle.noise.marker, 2) + " mm), " +
                     std::to_string(bundle.scene.targets.size()) + " targets";
  if (!bundle.scene.targets.empty()) {
    const double floor = bundle.noise.target * std::sqrt(3.0);
    text += " (noise " + fixed(bundle.noise.target, 2) + " mm per axis: no answer has an RMS below " + fixed(floor, 2) +
            " mm)";
  }
  return element(
      "p",
      text + "; " + std::to_string(evaluation.recordings.size()) + " trials at " + fixed(bundle.scene.rate, 0) + " Hz.",
      "class=\"lead\"");
}

// The smallest of a column is set in bold.
std::vector<std::string> error_column(const std::vector<SetupSummary>& summaries, double SetupSummary::*value) {
  double least = INFINITY;
  for (const SetupSummary& summary : summaries) least = std::fmin(least, summary.*value);
  std::vector<std::string> cells;
  for (const SetupSummary& summary : summaries) {
    const std::string cell = number(summary.*value, 2);
    cells.push_back(cell == number(least, 2) ? "<b>" + cell + "</b>" : cell);
  }
  return cells;
}

std::string summary_table(const BundleEvaluation& evaluation, const std::vector<SetupSummary>& summaries) {
  const auto& targets = evaluation.bundle.scene.targets;
  const std::string first = targets.empty() ? "target" : escape_html(targets.front().name);
  HtmlTable table({"model", "markers", first + " in hold, mm", "all targets in hold, mm", "RMS, mm", "p95, mm",
                   "max, mm", "in 95 % ellipsoid, %", "with sensor, %", "NEES", "NEES, with sensor",
                   "innovation RMS, mm", "step p50, ms", "step p99, ms", "thrown away"},
                  2);
  const auto first_hold = error_column(summaries, &SetupSummary::first_hold_mm);
  const auto hold = error_column(summaries, &SetupSummary::hold_mm);
  for (std::size_t s = 0; s < summaries.size(); ++s) {
    const SetupSummary& summary = summaries[s];
    const Setup& setup = evaluation.setups[s];
    const std::string markers =
        setup.closed_loop() ? escape_html(setup.marker_set) + " (" + std::to_string(evaluation.setup_markers(s)) + ")"
                            : "–";
    table.add_row({escape_html(setup.model.name), markers, first_hold[s], hold[s], number(summary.rms_mm, 2),
                   number(summary.p95_mm, 2), number(summary.max_mm, 2), percent(summary.inside_95),
                   percent(summary.inside_95_sensor), number(summary.nees, 2), number(summary.nees_sensor, 2),
                   number(summary.innovation_rms_mm, 3), number(summary.step_p50_ms, 2), number(summary.step_p99_ms, 2),
                   std::to_string(summary.diverged) + " of " + std::to_string(summary.frames)});
  }
  return table.html(
      "All trials together. Bold: the smallest. Thrown away: frames whose step was not finite and whose answer was the "
      "last good one.");
}

std::string trial_table(const BundleEvaluation& evaluation) {
  std::vector<std::string> headings{"trial", "pushes, mm"};
  for (const Setup& setup : evaluation.setups) headings.push_back(escape_html(setup_name(setup)));
  HtmlTable table(headings, 2);
  for (std::size_t r = 0; r < evaluation.recordings.size(); ++r) {
    std::vector<std::string> row{escape_html(evaluation.recordings[r].name()), pushes_text(evaluation, r)};
    for (std::size_t s = 0; s < evaluation.setups.size(); ++s) {
      std::vector<double> holds;
      for (const TargetScore& target : evaluation.runs[s][r].score.targets) holds.push_back(target.hold_mm);
      row.push_back(number(finite_mean(holds), 2));
    }
    table.add_row(std::move(row));
  }
  return table.html("Error in the hold, mean over targets, mm, by trial.");
}

std::string general_figures(const BundleEvaluation& evaluation, bool errors_shown) {
  const SetupList all = all_setups(evaluation), closed = closed_loop_setups(evaluation);
  std::string html;
  if (!errors_shown) {
    html += trial_table(evaluation) + trial_figure(evaluation, all, {}, "Error in the hold of every trial.");
    if (!evaluation.jump_trials.empty()) {
      html += jump_figure(evaluation, best_seen_setups(evaluation),
                          "The pads jump into the hold at once: error by ADMM iteration, of the trial with the largest "
                          "push for each choice of pads.");
    }
  }
  if (!evaluation.jump_trials.empty()) {
    html +=
        course_figure(evaluation, best_seen_setups(evaluation),
                      "The same trials as they were recorded: error by time, the error's vector averaged over 0.2 s "
                      "so that the sensor's noise does not hide it.");
  }
  if (!closed.empty()) {
    html += element("h3", "Do the ellipsoids hold what they claim?") +
            coverage_figure(
                evaluation, closed,
                "Share of all measurements, targets and frames together, inside the ellipsoid of every confidence. "
                "Dotted: honest. Above it the ellipsoids are wider than they need be, below it they promise too much.");
  }
  return html;
}

std::string bundle_section(const BundleEvaluation& evaluation) {
  std::vector<SetupSummary> summaries;
  for (const std::size_t s : all_setups(evaluation)) summaries.push_back(summarize(evaluation, s));
  std::string html = element("h2", "Bundle " + escape_html(evaluation.bundle.scene.name)) + about_bundle(evaluation) +
                     summary_table(evaluation, summaries);
  if (!evaluation.has_measured_target()) {
    html +=
        element("p", "No target was measured in these trials: there are no target errors to show.", "class=\"notice\"");
  } else {
    const bool is_paper = repeats_afshar(evaluation);
    if (is_paper) html += afshar_comparison(evaluation);
    if (repeats_tagliabue(evaluation)) html += tagliabue_comparison(evaluation);
    html += general_figures(evaluation, is_paper);
  }
  return html + element("h3", "Time per step") +
         step_time_figure(evaluation, all_setups(evaluation), "All frames of all trials, one thread per run.");
}

std::string heading(const Evaluation& evaluation, int threads) {
  std::vector<std::string> names;
  for (const auto& bundle : evaluation.bundles()) names.push_back(escape_html(bundle->bundle.scene.name));
  return element("h1", "Where the targets were said to be, and where they were") +
         element("p",
                 "An evaluation by <code>tissuectl evaluate</code> " + std::string(kVersion) + ", " + utc_now() + ": " +
                     join(names, ", ") + "; " + std::to_string(evaluation.run_count()) + " runs, " +
                     std::to_string(threads) + " at a time (step times feel one another then).",
                 "class=\"lead\"") +
         element("div", "This is research software, not a medical device. Nobody has tested it for clinical use.",
                 "class=\"notice\" role=\"note\"");
}

}  // namespace

std::string evaluation_page(const Evaluation& evaluation, int threads) {
  std::string body = heading(evaluation, threads) + model_table(*evaluation.bundles().front()) + how_measured();
  for (const auto& bundle : evaluation.bundles()) body += bundle_section(*bundle);
  return html_page("tissued: evaluation", kPageStyle, body);
}

}  // namespace tissued::daemon
