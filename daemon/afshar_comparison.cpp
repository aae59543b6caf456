#include "daemon/afshar_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>

#include "daemon/afshar_paper.hpp"
#include "daemon/evaluation_figures.hpp"
#include "daemon/evaluation_summary.hpp"
#include "daemon/html.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

// A model in closed loop and the open loop that differs from it by the filter alone.
struct Family {
  std::string name;
  std::optional<std::size_t> open_loop;
  std::optional<std::size_t> all_markers;  // the paper's 19
  std::optional<std::size_t> few_markers;  // the paper's 10
};

std::vector<std::string> keys_besides_filter(const EvaluatedModel& model) {
  std::vector<std::string> keys = model.overrides;
  std::erase_if(
      keys, [](const std::string& key) { return key.starts_with("simulator.kind=") || key.starts_with("filter."); });
  std::ranges::sort(keys);
  return keys;
}

std::optional<std::size_t> open_loop_of(const BundleEvaluation& bundle, const EvaluatedModel& model) {
  for (std::size_t s = 0; s < bundle.setups.size(); ++s) {
    const Setup& setup = bundle.setups[s];
    const bool is_admm = setup.config.simulator.kind == "admm";
    if (is_admm && keys_besides_filter(setup.model) == keys_besides_filter(model)) return s;
  }
  return std::nullopt;
}

std::vector<Family> families_of(const BundleEvaluation& bundle) {
  std::vector<Family> families;
  for (const std::size_t s : closed_loop_setups(bundle)) {
    const EvaluatedModel& model = bundle.setups[s].model;
    if (families.empty() || families.back().name != model.name) {
      families.push_back({model.name, open_loop_of(bundle, model), {}, {}});
    }
    if (bundle.setup_markers(s) == afshar::kMarkers) families.back().all_markers = s;
    if (bundle.setup_markers(s) == afshar::kFewMarkers) families.back().few_markers = s;
  }
  return families;
}

std::string number(double value, int digits) { return std::isfinite(value) ? fixed(value, digits) : "–"; }
std::string printed(const std::string& text) { return "<span class=\"printed\">" + text + "</span>"; }

// One row of the comparison: what the paper prints, and the same of every family.
using FamilyValue = std::function<double(const Family&)>;

class PaperTable {
 public:
  PaperTable(const BundleEvaluation& bundle, std::vector<Family> families)
      : bundle_(bundle), families_(std::move(families)), table_(headings(bundle, families_), 1) {}

  void add(const std::string& what, const std::string& in_paper, int digits, const FamilyValue& value) {
    std::vector<std::string> row{what, printed(in_paper)};
    for (const Family& family : families_) row.push_back(number(value(family), digits));
    table_.add_row(std::move(row));
  }

  // NaN where the family was not run so.
  double error(const std::optional<std::size_t>& setup) const {
    return setup ? summarize(bundle_, *setup).first_hold_mm : NAN;
  }
  double iterations(const std::optional<std::size_t>& setup) const {
    return setup ? iterations_to_settle(bundle_, *setup) : NAN;
  }
  double seconds(const std::optional<std::size_t>& setup, int iterations) const {
    if (!setup) return NAN;
    const int per_step = bundle_.setups[*setup].config.simulator.solver.iterations;
    return summarize(bundle_, *setup).step_p50_ms * 1e-3 * iterations / per_step;
  }
  std::string html(std::string_view caption) const { return table_.html(caption); }

 private:
  // `admm / kf-admm`: open loop / closed loop.
  static std::vector<std::string> headings(const BundleEvaluation& bundle, const std::vector<Family>& families) {
    std::vector<std::string> names{"", "paper, printed"};
    for (const Family& family : families) {
      const std::string open = family.open_loop ? bundle.setups[*family.open_loop].model.name + " / " : "";
      names.push_back(escape_html(open + family.name));
    }
    return names;
  }
  const BundleEvaluation& bundle_;
  std::vector<Family> families_;
  HtmlTable table_;
};

std::string printed_numbers(const BundleEvaluation& bundle) {
  PaperTable table(bundle, families_of(bundle));
  const auto count = std::to_string(bundle.recordings.size());
  const auto improvement = [&table](const std::optional<std::size_t>& setup, const Family& family) {
    return 100.0 * (1.0 - table.error(setup) / table.error(family.open_loop));
  };
  using afshar::kClosedLoopIterations;
  using afshar::kOpenLoopIterations;
  table.add("mean target error, open loop, mm", fixed(afshar::kOpenLoopError, 1), 2,
            [&](const Family& f) { return table.error(f.open_loop); });
  table.add("mean target error, 10 markers, mm", fixed(afshar::kFewMarkersError, 1), 2,
            [&](const Family& f) { return table.error(f.few_markers); });
  table.add("mean target error, 19 markers, mm", "≈ " + fixed(afshar::kClosedLoopError, 1), 2,
            [&](const Family& f) { return table.error(f.all_markers); });
  table.add("less than open loop, 10 markers, %", "–", 0,
            [&](const Family& f) { return improvement(f.few_markers, f); });
  table.add("less than open loop, 19 markers, %", std::to_string(afshar::kImprovement), 0,
            [&](const Family& f) { return improvement(f.all_markers, f); });
  table.add("iterations until settled, open loop", "≈ " + std::to_string(kOpenLoopIterations), 0,
            [&](const Family& f) { return table.iterations(f.open_loop); });
  table.add("iterations until settled, 19 markers", "≈ " + std::to_string(kClosedLoopIterations), 0,
            [&](const Family& f) { return table.iterations(f.all_markers); });
  table.add("time of 500 iterations, open loop, s", fixed(afshar::kOpenLoopTime, 2), 3,
            [&](const Family& f) { return table.seconds(f.open_loop, kOpenLoopIterations); });
  table.add("time of 200 iterations, 19 markers, s", fixed(afshar::kClosedLoopTime, 2), 3,
            [&](const Family& f) { return table.seconds(f.all_markers, kClosedLoopIterations); });
  return table.html(
      "Ours: target " + escape_html(bundle.bundle.scene.targets.front().name) + " in the hold, mean over " + count +
      " trials; settled: from there on the target stays within 5 % of its way, mean over the trials of Fig. 5; times: "
      "median "
      "step, " +
      std::to_string(bundle.setups.front().scene.mesh.tet_count()) +
      " tetrahedra, one thread. The paper: " + std::to_string(afshar::kTetrahedra) +
      " tetrahedra, 6 cores; ≈: said as a round number in its text. Its body is a plastisol phantom, ours a recording "
      "computed by quadratic finite elements: magnitudes can be set side by side, digits cannot.");
}

// Number of the experiment that a trial named expNN repeats.
std::optional<afshar::Experiment> experiment_of(const std::string& trial) {
  const auto found = std::ranges::find_if(afshar::kExperiments, [&](const afshar::Experiment& experiment) {
    char name[8];
    std::snprintf(name, sizeof name, "exp%02d", experiment.number);
    return trial == name;
  });
  return found != afshar::kExperiments.end() ? std::optional(*found) : std::nullopt;
}

std::string table_1(const BundleEvaluation& bundle) {
  std::vector<std::string> headings{"experiment", "active actuator", "movement, mm", "as recorded, mm"};
  for (const Setup& setup : bundle.setups) headings.push_back(escape_html(setup_name(setup)));
  HtmlTable table(headings, 4);
  for (std::size_t r = 0; r < bundle.recordings.size(); ++r) {
    const Recording& recording = bundle.recordings[r];
    const auto experiment = experiment_of(recording.name());
    if (!experiment) continue;
    std::vector<std::string> row{printed(std::to_string(experiment->number)), printed(experiment->actuators),
                                 printed(std::to_string(experiment->movement_mm)), pushes_text(bundle, r)};
    for (std::size_t s = 0; s < bundle.setups.size(); ++s) {
      row.push_back(number(bundle.runs[s][r].score.targets.front().hold_mm, 2));
    }
    table.add_row(std::move(row));
  }
  std::vector<std::string> mean{"mean", "", "", ""};
  for (std::size_t s = 0; s < bundle.setups.size(); ++s) mean.push_back(number(summarize(bundle, s).first_hold_mm, 2));
  table.add_total(std::move(mean));
  return table.html(
      "<b>Table I</b> of the paper (in italics: as printed), the pushes found in the recordings, and the error of "
      "target " +
      escape_html(bundle.bundle.scene.targets.front().name) + " in the hold, mm.");
}

}  // namespace

bool repeats_afshar(const BundleEvaluation& bundle) {
  return bundle.bundle.scene.name == afshar::kBundleName && !bundle.bundle.scene.targets.empty();
}

std::string afshar_comparison(const BundleEvaluation& bundle) {
  std::string html =
      element("h3", "Beside the first paper") +
      element("p",
              "Afshar et al., <i>Accurate Tissue Deformation Modelling Using a Kalman Filter and ADMM-based "
              "Projective Dynamics</i>. Numbers in italics are printed there. Its curves come without "
              "numbers and are not redrawn.") +
      printed_numbers(bundle) + table_1(bundle);
  if (!bundle.jump_trials.empty()) {
    html +=
        jump_figure(bundle, best_seen_setups(bundle),
                    "<b>Fig. 5</b> of the paper, from our runs: the pads jump into the hold at once, and the error is "
                    "followed from iteration to iteration, open loop and closed loop with the largest marker set. "
                    "Every point is a frame; the truth is the mean measurement in the hold.");
    html += jump_figure(bundle, closed_loop_setups(bundle),
                        "<b>Fig. 6</b> of the paper, from our runs: the same in closed loop, by marker set.");
  }
  html +=
      trial_figure(bundle, all_setups(bundle),
                   {{afshar::kOpenLoopError, "paper, open loop: 1.7"},
                    {afshar::kFewMarkersError, "paper, 10 markers: 1.1"},
                    {afshar::kClosedLoopError, "paper, 19 markers: ≈ 0.8"}},
                   "<b>Fig. 7</b> of the paper, from our runs: error in the hold of every experiment. Dotted: means "
                   "over the 16 experiments that the paper prints, for its one target.");
  return html;
}

}  // namespace tissued::daemon
