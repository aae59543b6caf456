// The figures of an evaluation, as HTML: SVG with a legend and a caption.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/evaluation.hpp"
#include "daemon/svg_plot.hpp"

namespace tissued::daemon {

/// Setups by their place in BundleEvaluation::setups.
using SetupList = std::vector<std::size_t>;

/// Every setup of the bundle, those in closed loop, and for comparisons of models: every open loop, and of each model
/// in closed loop the setup with the most markers.
SetupList all_setups(const BundleEvaluation& bundle);
SetupList closed_loop_setups(const BundleEvaluation& bundle);
SetupList best_seen_setups(const BundleEvaluation& bundle);

/// `kf-admm, set1`; in open loop the model alone.
std::string setup_name(const Setup& setup);
SeriesStyle setup_style(const BundleEvaluation& bundle, std::size_t setup);

/// `A1 by 10, A3 by 10`: the pads of a recording and their largest pushes, mm.
std::string pushes_text(const BundleEvaluation& bundle, std::size_t recording);

/// Error of the bundle's first target after the pads' jump into the hold, by ADMM iteration: one panel per jump trial.
std::string jump_figure(const BundleEvaluation& bundle, const SetupList& setups, std::string_view caption);

/// Error of the first target over the trial as it was recorded, panels as above.
std::string course_figure(const BundleEvaluation& bundle, const SetupList& setups, std::string_view caption);

/// Error in the hold of every trial: of the first target, and the mean over targets where there are several.
/// references: for the first target.
std::string trial_figure(const BundleEvaluation& bundle, const SetupList& setups,
                         const std::vector<ReferenceLine>& references, std::string_view caption);

/// Share of measurements inside the ellipsoid of every confidence, as claimed and widened by the sensor's noise.
std::string coverage_figure(const BundleEvaluation& bundle, const SetupList& setups, std::string_view caption);

/// A plot of dots with the legend of its own series, over the whole width.
std::string dot_figure(const DotPlot& plot, std::string_view caption);

/// Time per step, median to 99 %.
std::string step_time_figure(const BundleEvaluation& bundle, const SetupList& setups, std::string_view caption);

/// First ADMM iteration after the jump from which on the first target's answer stays near where it ends (the mean over
/// the last tenth), within 5 % of its way there; mean over the jump trials, NaN without any.
double iterations_to_settle(const BundleEvaluation& bundle, std::size_t setup);

/// Cumulative distribution of chi square with 3 degrees of freedom.
double chi_square_3(double value);

}  // namespace tissued::daemon
