#include "daemon/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "config/daemon_config.hpp"
#include "config/document.hpp"
#include "config/schema.hpp"
#include "daemon/ctl_options.hpp"
#include "daemon/explained_model.hpp"
#include "daemon/run_score.hpp"
#include "daemon/scene_loader.hpp"
#include "daemon/trial_run.hpp"
#include "protocol/text_fields.hpp"

namespace tissued::daemon {
namespace {

void require_known(const std::vector<std::string>& wanted, const std::vector<std::string>& known, const char* option) {
  for (const std::string& name : wanted) {
    if (std::ranges::count(known, name) == 0)
      throw UsageError(std::string(option) + ": the bundle has no `" + name + "`; it has " + join_or(known));
  }
}

bool ends_in_hold(const Recording& recording, std::size_t target) {
  return std::ranges::any_of(recording.hold(),
                             [&](std::size_t frame) { return recording.target(frame, target).has_value(); });
}

}  // namespace

config::JsonPointer pointer_to(const std::string& key) {
  std::string pointer = "/" + key;
  std::ranges::replace(pointer, '.', '/');
  return config::JsonPointer(pointer);
}

Calibration::Calibration(const CalibrationRequest& request)
    : request_(request), bundle_(config::load_bundle(request.bundle)) {
  std::vector<std::string> trials, targets;
  for (const config::TrialInfo& trial : bundle_.trials) trials.push_back(trial.name);
  for (const core::Target& target : bundle_.scene.targets) targets.push_back(target.name);
  require_known(request_.trials, trials, "--trials");
  require_known(request_.targets, targets, "--target");
  try_bounds();
  for (const config::TrialInfo& trial : bundle_.trials) {
    const bool named = std::ranges::count(request_.trials, trial.name) > 0;
    if (request_.trials.empty() ? !trial.held_out : named)
      recordings_.emplace_back(bundle_, trial, read_trial(trial.file));
  }
  for (const Recording& recording : recordings_)
    for (std::size_t target = 0; target < targets.size(); ++target)
      if (is_wanted(target) && ends_in_hold(recording, target)) ++distances_;
  if (distances_ == 0) throw UsageError("no trial has a target that was recorded while its pads held");
}

bool Calibration::is_wanted(std::size_t target) const {
  return request_.targets.empty() || std::ranges::count(request_.targets, bundle_.scene.targets[target].name) > 0;
}

std::vector<std::string> Calibration::overrides_at(const SearchPoint& point) const {
  std::vector<std::string> overrides{"simulator.kind=" + request_.model};
  overrides.insert(overrides.end(), request_.overrides.begin(), request_.overrides.end());
  for (std::size_t i = 0; i < point.size(); ++i)
    protocol::append_number(overrides.emplace_back(request_.keys[i].key + "="), point[i]);
  return overrides;
}

// What stays is to be right as a whole; bounds by the schema alone, for that two keys limit each other is a matter of
// points. Something between them is tried, too: a key may want whole numbers.
void Calibration::try_bounds() const {
  config::config_for_bundle(request_.bundle, overrides_at({}));
  constexpr double kBetween = 0.382;
  for (const double share : {0.0, 1.0, kBetween}) {
    SearchPoint point;
    for (const VariedKey& key : request_.keys) point.push_back(key.low + share * (key.high - key.low));
    const config::Json bare = {{"format", "tissued-config/1"}, {"bundle", request_.bundle}};
    const config::Document checked(bare, request_.bundle, overrides_at(point), config::config_schema());
  }
}

double Calibration::part(const SearchPoint& point, std::size_t trial) const {
  std::vector<std::string> overrides = overrides_at(point);
  overrides.emplace_back("simulator.threads=1");
  overrides.emplace_back("alarm.enabled=false");
  config::DaemonConfig config;
  try {
    config = config::config_for_bundle(request_.bundle, overrides);
  } catch (const config::ConfigError&) {
    return kRefused;
  }
  apply_model(config);
  const core::Scene scene = load_scene(config.bundle);
  const Recording& recording = recordings_[trial];
  if (recording.hold().empty()) return 0.0;
  std::vector<std::size_t> order = recorded_order(recording);
  order.resize(recording.hold().back() + 1);
  const RunScore score = score_run(bundle_, recording, run_trial(config, scene, recording, order));
  double sum = 0.0;
  for (std::size_t target = 0; target < score.targets.size(); ++target)
    if (is_wanted(target) && std::isfinite(score.targets[target].hold_mm)) sum += score.targets[target].hold_mm;
  return sum;
}

config::Json Calibration::config_at(const SearchPoint& point) const {
  config::Json document = {{"format", "tissued-config/1"},
                           {"bundle", std::filesystem::absolute(request_.bundle).lexically_normal().string()}};
  for (const std::string& override : overrides_at(point)) {
    const std::size_t equals = override.find('=');
    const std::string value = override.substr(equals + 1);
    const config::Json parsed = config::Json::parse(value, nullptr, false);
    document[pointer_to(override.substr(0, equals))] = parsed.is_discarded() ? config::Json(value) : parsed;
  }
  return document;
}

}  // namespace tissued::daemon
