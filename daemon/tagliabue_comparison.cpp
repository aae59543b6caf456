#include "daemon/tagliabue_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "daemon/error_table.hpp"
#include "daemon/evaluation_figures.hpp"
#include "daemon/evaluation_summary.hpp"
#include "daemon/html.hpp"
#include "daemon/tagliabue_paper.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

using tagliabue::PushRange;

std::string number(double value, int digits) { return std::isfinite(value) ? fixed(value, digits) : "–"; }
std::string printed(const std::string& text) { return "<span class=\"printed\">" + text + "</span>"; }

bool is_breast(const BundleEvaluation& bundle) { return bundle.bundle.scene.name == tagliabue::kBreastName; }

double largest_push(const Recording& recording) {
  double most = 0.0;
  for (const PadPush& push : recording.pushes()) most = std::max(most, push.largest_mm);
  return most;
}

// A column of its own for every push, rounded to a millimetre.
struct PushColumn {
  std::string name;
  double low, high;
};

// The breast's as the paper groups them, even where nothing was recorded; the block's one by one.
std::vector<PushColumn> push_columns(const BundleEvaluation& bundle) {
  std::vector<PushColumn> columns;
  if (is_breast(bundle)) {
    for (const PushRange& range : tagliabue::kRanges) columns.push_back({range.name, range.low, range.high});
    return columns;
  }
  std::vector<long> pushes;
  for (const Recording& recording : bundle.recordings) pushes.push_back(std::lround(largest_push(recording)));
  std::ranges::sort(pushes);
  const auto repeated = std::ranges::unique(pushes);
  pushes.erase(repeated.begin(), repeated.end());
  for (const long push : pushes) {
    const auto middle = static_cast<double>(push);
    columns.push_back({std::to_string(push) + " mm", middle - 0.5, middle + 0.5});
  }
  return columns;
}

// Error in the hold, mean over the trials of a column.
ErrorTable errors_of(const BundleEvaluation& bundle, std::size_t setup) {
  ErrorTable table;
  const std::vector<PushColumn> columns = push_columns(bundle);
  for (const PushColumn& column : columns) table.pushes.push_back(column.name);
  for (std::size_t target = 0; target < bundle.bundle.scene.targets.size(); ++target) {
    table.targets.push_back(bundle.bundle.scene.targets[target].name);
    std::vector<double>& row = table.mm.emplace_back();
    for (const PushColumn& column : columns) {
      std::vector<double> holds;
      for (std::size_t r = 0; r < bundle.recordings.size(); ++r) {
        const double push = largest_push(bundle.recordings[r]);
        if (push >= column.low && push < column.high)
          holds.push_back(bundle.runs[setup][r].score.targets[target].hold_mm);
      }
      row.push_back(finite_mean(holds));
    }
  }
  return table;
}

ErrorTable printed_errors(const tagliabue::LesionErrors& errors) {
  ErrorTable table;
  for (const PushRange& range : tagliabue::kRanges) table.pushes.emplace_back(range.name);
  for (std::size_t lesion = 0; lesion < errors.size(); ++lesion) {
    table.targets.emplace_back("T").append(std::to_string(lesion + 1));
    table.mm.emplace_back(errors[lesion].begin(), errors[lesion].end());
  }
  return table;
}

// A model of ours, or one of the paper's.
struct Shown {
  std::string name;
  SeriesStyle style;
  ErrorTable errors;
  bool is_printed;
};

std::vector<Shown> all_shown(const BundleEvaluation& bundle) {
  std::vector<Shown> shown;
  std::size_t colour = 0;
  for (const std::size_t s : best_seen_setups(bundle)) {
    const SeriesStyle style = setup_style(bundle, s);
    colour = std::max(colour, style.colour + 1);
    shown.push_back({setup_name(bundle.setups[s]), style, errors_of(bundle, s), false});
  }
  if (is_breast(bundle)) {
    shown.push_back({"paper, PBD", {colour, 1}, printed_errors(tagliabue::kPbd), true});
    shown.push_back({"paper, FE", {colour + 1, 2}, printed_errors(tagliabue::kFiniteElements), true});
  }
  return shown;
}

std::string cell(const Shown& shown, double value) {
  const std::string text = number(value, shown.is_printed ? 3 : 2);
  return shown.is_printed ? printed(text) : text;
}

std::string lesion_table(const Shown& shown) {
  const ErrorTable& errors = shown.errors;
  std::vector<std::string> headings{"target"};
  headings.insert(headings.end(), errors.pushes.begin(), errors.pushes.end());
  headings.insert(headings.end(), {"mean", "STD"});
  HtmlTable table(headings, 1);
  const auto add = [&](const std::string& name, const std::vector<double>& values, const std::string& mean,
                       const std::string& std, bool total) {
    std::vector<std::string> row{escape_html(name)};
    for (const double value : values) row.push_back(cell(shown, value));
    row.insert(row.end(), {mean, std});
    total ? table.add_total(std::move(row)) : table.add_row(std::move(row));
  };
  for (std::size_t t = 0; t < errors.targets.size(); ++t) {
    const std::vector<double>& row = errors.mm[t];
    add(errors.targets[t], row, cell(shown, finite_mean(row)), cell(shown, population_std(row)), false);
  }
  std::vector<double> spreads;
  for (std::size_t push = 0; push < errors.pushes.size(); ++push)
    spreads.push_back(population_std(errors.column(push)));
  add("mean", errors.push_means(), shown.is_printed ? "" : cell(shown, errors.mean()), "", true);
  add("STD", spreads, "", "", true);
  return element("div", table.html(element("b", escape_html(shown.name))));
}

std::string table_3(const std::vector<Shown>& shown, bool breast) {
  std::string tables;
  for (const Shown& model : shown) tables += lesion_table(model);
  const std::string about =
      breast ? "<b>Table 3</b> of the paper: mean error in the hold, mm, by lesion and push (D10: below 12.5 mm; D15, "
               "D20, D25: 5 mm wide around their number; D30: from 27.5 mm). In italics: as printed there. The "
               "recordings push by 8, 14 and 20 mm, all ten lesions by every pad; the paper pressed above each."
             : "Mean error in the hold, mm, by bead and push.";
  return element("p", about) + element("div", tables, "class=\"panels\"");
}

// Against rigid, which is what a reader of images has without a model.
std::string against_rigid(const BundleEvaluation& bundle, const std::vector<Shown>& shown) {
  const SetupList setups = best_seen_setups(bundle);
  const auto rigid = std::ranges::find_if(setups, [&](std::size_t s) {
    const core::SimulatorOptions& options = bundle.setups[s].config.simulator;
    return options.kind == "rigid" && !bundle.setups[s].closed_loop();
  });
  if (rigid == setups.end()) return {};
  const ErrorTable still = errors_of(bundle, *rigid);
  const std::vector<double> still_means = still.target_means();
  HtmlTable table({"model", "mean error, mm", "of rigid's", "targets above half of rigid's"}, 1);
  for (const Shown& model : shown) {
    if (model.is_printed) continue;
    const std::vector<double> means = model.errors.target_means();
    std::string worse;
    for (std::size_t t = 0; t < means.size(); ++t)
      if (means[t] > 0.5 * still_means[t])
        worse += (worse.empty() ? "" : ", ") + escape_html(model.errors.targets[t]) + " " +
                 number(means[t] / still_means[t], 2);
    if (worse.empty()) worse = "none";
    if (model.name == setup_name(bundle.setups[*rigid])) worse = "–";
    table.add_row({escape_html(model.name), number(model.errors.mean(), 2),
                   number(model.errors.mean() / still.mean(), 2), worse});
  }
  return table.html(
      "Beside targets that stay where they were (rigid). The paper: its deformable models halve rigid's error at every "
      "lesion at least.");
}

std::string table_2(const BundleEvaluation& bundle) {
  HtmlTable table({"clusters", "spacing, mm", "radius, mm", "stiffness", "mean error of the landmark, mm", "STD"}, 1);
  for (const tagliabue::Calibrated& row : tagliabue::kTable2)
    table.add_row({printed(std::string("paper, ") + row.phantom), printed(fixed(row.cluster_spacing, 4)),
                   printed(fixed(row.cluster_radius, 4)), printed(fixed(row.cluster_stiffness, 6)),
                   printed(fixed(row.mean_error, 2)), printed(fixed(row.std_error, 2))});
  bool any = false;
  for (const std::size_t s : best_seen_setups(bundle)) {
    const core::SimulatorOptions& options = bundle.setups[s].config.simulator;
    if (options.kind != "pbd") continue;
    any = true;
    std::vector<double> holds;
    for (const EvaluatedRun& run : bundle.runs[s]) holds.push_back(run.score.targets.front().hold_mm);
    table.add_row({escape_html(setup_name(bundle.setups[s])), fixed(options.pbd.cluster_spacing, 4),
                   fixed(options.pbd.cluster_radius, 4), fixed(options.pbd.cluster_stiffness, 6),
                   number(finite_mean(holds), 2), number(population_std(holds), 2)});
  }
  return any ? table.html("<b>Table 2</b> of the paper: clusters, and the error of target " +
                          escape_html(bundle.bundle.scene.targets.front().name) +
                          " with them over all trials. In italics: as printed there, of another body. The numbers of "
                          "others are found by <code>tissuectl calibrate</code>.")
             : "";
}

// The time that one trial's steps took, s, without what a tracker waits for between them.
double computing_seconds(const EvaluatedRun& run) {
  double seconds = 0.0;
  for (const RunFrame& frame : run.recorded) seconds += 1e-9 * static_cast<double>(frame.step_time_ns);
  return seconds;
}

std::string times(const BundleEvaluation& bundle) {
  constexpr double kLeastTime = 1e-3;  // ms, of a step that does something
  HtmlTable table({"model", "step p50, ms", "step p99, ms", "steps a second", "a whole push, s", "which lasted, s"}, 1);
  for (const std::size_t s : best_seen_setups(bundle)) {
    const SetupSummary summary = summarize(bundle, s);
    std::vector<double> computed, lasted;
    for (const EvaluatedRun& run : bundle.runs[s]) {
      computed.push_back(computing_seconds(run));
      lasted.push_back(run.recorded.empty() ? NAN : run.recorded.back().time);
    }
    const bool is_timed = summary.step_p50_ms > kLeastTime;
    table.add_row({escape_html(setup_name(bundle.setups[s])), number(summary.step_p50_ms, 3),
                   number(summary.step_p99_ms, 3), number(is_timed ? 1e3 / summary.step_p50_ms : NAN, 0),
                   number(finite_mean(computed), 2), number(finite_mean(lasted), 2)});
  }
  table.add_total({printed("paper, PBD"), "", "", "", printed(fixed(tagliabue::kPbdTime, 2)), ""});
  table.add_total({printed("paper, FE"), "", "", "", printed(fixed(tagliabue::kFiniteElementTime, 2)), ""});
  const core::TetMesh& mesh = bundle.setups.front().scene.mesh;
  return table.html("What each costs: processor time of steps, one thread, " + std::to_string(mesh.tet_count()) +
                    " tetrahedra; a push is a whole trial, moving and held. In italics: as the paper prints, " +
                    std::to_string(tagliabue::kTetrahedra) + " tetrahedra in its FE, on its machine.");
}

// values: of one shown model, along the plot's categories.
std::string error_figure(const std::vector<Shown>& shown, const std::vector<std::string>& categories,
                         std::vector<double> (ErrorTable::*values)() const, bool with_means,
                         const std::string& caption) {
  DotPlot plot;
  plot.categories = categories;
  double most = 0.0;
  for (const Shown& model : shown) {
    plot.series.push_back({model.name, model.style, (model.errors.*values)()});
    for (const double value : plot.series.back().values) most = std::fmax(most, value);
    if (with_means) plot.references.push_back({model.errors.mean(), model.name + ": " + fixed(model.errors.mean(), 2)});
  }
  plot.y = {"error in the hold, mm", 0.0, round_up(1.05 * most)};
  return dot_figure(plot, caption);
}

}  // namespace

bool repeats_tagliabue(const BundleEvaluation& bundle) {
  const std::string& name = bundle.bundle.scene.name;
  return (name == tagliabue::kBlockName || name == tagliabue::kBreastName) && bundle.has_measured_target();
}

std::string tagliabue_comparison(const BundleEvaluation& bundle) {
  const std::vector<Shown> shown = all_shown(bundle);
  const bool breast = is_breast(bundle);
  const ErrorTable& first = shown.front().errors;
  const std::string of_paper = breast ? " of the paper, from our runs and its Table 3: " : " of the paper for beads: ";
  return element("h3", "Beside the second paper") +
         element("p",
                 "Tagliabue et al. 2019, <i>Position-based modeling of lesion displacement in ultrasound-guided breast "
                 "biopsy</i>. Its bodies were phantoms pressed by a probe; ours are recordings computed by quadratic "
                 "finite elements, pressed by pads: orders can be set side by side, digits cannot.") +
         against_rigid(bundle, shown) + table_2(bundle) + table_3(shown, breast) + times(bundle) +
         error_figure(shown, first.pushes, &ErrorTable::push_means, false,
                      "<b>Fig. 6</b>" + of_paper + "mean error by push. Its rigid model comes without numbers.") +
         error_figure(shown, first.targets, &ErrorTable::target_means, true,
                      "<b>Fig. 7</b>" + of_paper + "mean error by target. Dotted: means over all.");
}

}  // namespace tissued::daemon
