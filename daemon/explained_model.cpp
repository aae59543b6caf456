#include "daemon/explained_model.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "config/config_error.hpp"

namespace tissued::daemon {
namespace {

using nlohmann::json;
constexpr const char* kFormat = "tissued-model/1";

json effect_json(const core::Effect& effect, const core::Fit& fit, const core::Scene& scene) {
  const std::vector<double> values = core::effect_values(effect, fit, scene);
  json numbers = json::object();
  for (std::size_t k = 0; k < values.size(); ++k) numbers[effect.parameters()[k].name] = values[k];
  return {{"kind", effect.kind()}, {"parameters", numbers}};
}

json faults_json(const core::Diagnosis& diagnosis, const core::Scene& scene) {
  const core::Fit& fit = diagnosis.explained.best();
  json faults = json::object(), released = json::object();
  for (const core::Unknown& unknown : fit.unknowns) {
    if (unknown.source != core::Unknown::Source::fault) continue;
    if (unknown.fault >= 0)
      faults[unknown.name] = unknown.value;
    else
      released[diagnosis.courses.at(static_cast<std::size_t>(-1 - unknown.fault)).name] = unknown.value;
  }
  json markers = json::array();
  for (const core::SlippedMarker& slip : fit.hypothesis.slips) markers.push_back(scene.markers[slip.marker].name);
  return {{"numbers", faults}, {"slipped", markers}, {"released", released}};
}

// Reads with the place in the file in every message.
class ModelReader {
 public:
  ModelReader(std::filesystem::path path, const core::Scene& scene) : path_(std::move(path)), scene_(&scene) {}

  ExplainedModel read() {
    std::ifstream file(path_);
    if (!file) throw config::ConfigError(path_.string() + ": cannot be read: " + std::strerror(errno));
    json all;
    try {
      all = json::parse(file);
    } catch (const json::parse_error& error) {
      throw config::ConfigError(path_.string() + ": " + error.what());
    }
    if (!all.is_object() || all.value("format", json()) != kFormat) fail("/format", std::string("is not ") + kFormat);
    // Its numbers and offsets are of one body.
    if (all.contains("bundle") && all["bundle"] != scene_->name)
      fail("/bundle", "was found of " + all["bundle"].dump() + ", not of " + json(scene_->name).dump());
    ExplainedModel model;
    core::Fit& fit = model.candidate.exact;
    fit.solved = true;
    add_numbers(member(all, "material", "/material"), fit);
    const json& effects = member(all, "effects", "/effects");
    if (!effects.is_array()) fail("/effects", "is not a list");
    for (std::size_t i = 0; i < effects.size(); ++i) add_effect(effects[i], "/effects/" + std::to_string(i), model);
    add_faults(member(all, "measurement", "/measurement"), model);
    add_offsets(member(all, "marker_offsets", "/marker_offsets"), model);
    if (all.contains("left")) model.left = number(all, "left", "/left", 0.0, 1e3);
    return model;
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    throw config::ConfigError(path_.string() + ": " + key + ": " + what);
  }
  const json& member(const json& object, const std::string& name, const std::string& key) const {
    if (!object.is_object() || !object.contains(name)) fail(key, "is missing");
    return object.at(name);
  }
  double number(const json& object, const std::string& name, const std::string& key, double lowest,
                double highest) const {
    const json& value = member(object, name, key);
    if (!value.is_number() || !std::isfinite(value.get<double>())) fail(key, "is not a number");
    if (value.get<double>() < lowest || value.get<double>() > highest)
      fail(key, value.dump() + " is not within " + json(lowest).dump() + " and " + json(highest).dump());
    return value.get<double>();
  }
  static core::Unknown unknown(const std::string& name, core::Unknown::Source source, double value) {
    core::Unknown out;
    out.name = name;
    out.source = source;
    out.value = value;
    return out;
  }

  void add_numbers(const json& material, core::Fit& fit) const {
    const core::Effect& numbers = *core::find_effect("parameters");
    for (const core::EffectParameter& parameter : numbers.parameters()) {
      if (!material.contains(parameter.name)) continue;
      const double value =
          number(material, parameter.name, "/material/" + parameter.name, parameter.lowest, parameter.highest);
      fit.unknowns.push_back(unknown(parameter.name, core::Unknown::Source::body, value));
    }
  }

  void add_effect(const json& object, const std::string& key, ExplainedModel& model) const {
    const json& kind = member(object, "kind", key + "/kind");
    const core::Effect* effect = kind.is_string() ? core::find_effect(kind.get<std::string>()) : nullptr;
    if (effect == nullptr) fail(key + "/kind", kind.dump() + " is no effect that is known");
    model.candidate.kinds.emplace_back(effect->kind());
    model.candidate.hypothesis.effects.push_back(effect);
    const json& numbers = member(object, "parameters", key + "/parameters");
    for (const core::EffectParameter& parameter : effect->parameters()) {
      const double value =
          number(numbers, parameter.name, key + "/parameters/" + parameter.name, parameter.lowest, parameter.highest);
      model.candidate.exact.unknowns.push_back(
          unknown(core::model_parameter(*effect, parameter), core::Unknown::Source::body, value));
    }
  }

  void add_faults(const json& measurement, ExplainedModel& model) const {
    const json& slipped = member(measurement, "slipped", "/measurement/slipped");
    for (const json& name : slipped) {
      int index = -1;
      for (std::size_t i = 0; i < scene_->markers.size(); ++i)
        if (name.is_string() && scene_->markers[i].name == name.get<std::string>()) index = static_cast<int>(i);
      if (index < 0) fail("/measurement/slipped", name.dump() + " is no marker of the bundle");
      model.candidate.hypothesis.slips.push_back({index, 0, 0.0, core::Vec3::Zero()});
    }
    const json& numbers = member(measurement, "numbers", "/measurement/numbers");
    if (!numbers.is_object()) fail("/measurement/numbers", "is not an object");
    const std::vector<std::string> names = core::fault_names(model.candidate.hypothesis.slips, *scene_);
    for (const auto& [name, value] : numbers.items()) {
      const auto at = std::find(names.begin(), names.end(), name);
      if (at == names.end()) fail("/measurement/numbers/" + name, "is unknown");
      core::Unknown fault =
          unknown(name, core::Unknown::Source::fault, number(numbers, name, "/measurement/numbers/" + name, -1e3, 1e3));
      fault.fault = static_cast<int>(at - names.begin());
      model.candidate.exact.unknowns.push_back(fault);
    }
    if (!measurement.contains("released")) return;
    const json& released = measurement.at("released");
    if (!released.is_object()) fail("/measurement/released", "is not an object");
    for (const auto& [trial, value] : released.items())
      model.released[trial] = number(released, trial, "/measurement/released/" + trial, -1e3, 1e3);
  }

  void add_offsets(const json& offsets, ExplainedModel& model) const {
    model.offset.setZero(core::channels_of(*scene_).count());
    for (std::size_t i = 0; i < scene_->markers.size(); ++i) {
      const std::string key = "/marker_offsets/" + scene_->markers[i].name;
      if (!offsets.contains(scene_->markers[i].name)) continue;
      const json& offset = offsets.at(scene_->markers[i].name);
      if (!offset.is_array() || offset.size() != 3 || !offset[0].is_number() || !offset[1].is_number() ||
          !offset[2].is_number())
        fail(key, "is not three numbers in mm");
      for (int axis = 0; axis < 3; ++axis) model.offset[3 * static_cast<int>(i) + axis] = offset[axis].get<double>();
    }
  }

  std::filesystem::path path_;
  const core::Scene* scene_;
};

// RMS of what is left at the markers beyond noise over the RMS of the load; none where no load was seen.
std::optional<double> left_share(const core::Diagnosis& diagnosis) {
  double square = 0.0, frames = 0.0;
  for (const core::TrialCourse& course : diagnosis.courses) {
    if (course.held_out != diagnosis.held_out_seen) continue;
    for (double load : course.load) square += load * load;
    frames += static_cast<double>(course.load.size());
  }
  const core::Misfits& misfits = diagnosis.held_out_seen ? diagnosis.held_out : diagnosis.trials;
  const double excess = std::pow(misfits.explained.marker_mm, 2) - std::pow(diagnosis.noise_marker_mm, 2);
  if (!(square > 0.0) || !std::isfinite(excess)) return std::nullopt;
  return std::sqrt(std::max(0.0, excess) * frames / square);
}

}  // namespace

void write_model(const core::Diagnosis& diagnosis, const core::Scene& scene, const std::filesystem::path& path) {
  const core::Fit& fit = diagnosis.explained.best();
  json material{{"youngs_modulus", scene.material.youngs_modulus},
                {"poissons_ratio", scene.material.poissons_ratio},
                {"density", scene.material.density}};
  for (const char* name : {"youngs_modulus", "poissons_ratio"})
    if (fit.has(name)) material[name] = fit.value(name);
  json effects = json::array();
  for (const core::Effect* effect : fit.hypothesis.effects) effects.push_back(effect_json(*effect, fit, scene));
  json offsets = json::object();
  for (std::size_t i = 0; i < scene.markers.size(); ++i) {
    const auto offset = diagnosis.offset.segment<3>(3 * static_cast<Eigen::Index>(i));
    offsets[scene.markers[i].name] = {offset[0], offset[1], offset[2]};
  }
  json all{{"format", kFormat},        {"bundle", diagnosis.bundle}, {"verdict", core::name_of(diagnosis.verdict)},
           {"material", material},     {"effects", effects},         {"measurement", faults_json(diagnosis, scene)},
           {"marker_offsets", offsets}};
  if (const auto left = left_share(diagnosis)) all["left"] = *left;
  std::ofstream file(path);
  file << all.dump(1) << '\n';
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written");
}

ExplainedModel read_model(const std::filesystem::path& path, const core::Scene& scene) {
  return ModelReader(path, scene).read();
}

void apply_model(config::DaemonConfig& config) {
  if (config.model.empty()) return;
  core::Scene& scene = config.bundle.scene;
  core::Scene all = scene;
  for (const std::string& name : config.unused_markers) all.markers.push_back({name, core::Vec3::Zero()});
  const ExplainedModel model = read_model(config.model, all);
  const core::Fit& fit = model.candidate.best();
  core::Material& material = scene.material;
  for (const auto& [name, number] :
       {std::pair{"youngs_modulus", &material.youngs_modulus}, std::pair{"poissons_ratio", &material.poissons_ratio},
        std::pair{"density", &material.density}})
    if (fit.has(name)) *number = fit.value(name);
  for (const core::Effect* effect : model.candidate.hypothesis.effects) {
    core::EffectSetting setting{effect, {}};
    for (const core::EffectParameter& parameter : effect->parameters())
      setting.values.push_back(fit.value(core::model_parameter(*effect, parameter)));
    config.simulator.effects.push_back(std::move(setting));
  }
  // What the filter supposes of a body that nobody diagnosed goes with its discrepancy.
  constexpr double kLeast = 0.1;
  if (core::FilterOptions& filter = config.simulator.filter; model.left && filter.discrepancy > 0.0) {
    const double share = std::clamp(*model.left / filter.discrepancy, kLeast, 1.0);
    for (double* size : {&filter.stiffness_sd, &filter.slip, &filter.discrepancy}) *size *= share;
  }
  const core::MeasurementFaults faults = core::faults_of(model.candidate.hypothesis, fit.unknowns);
  config.marker_delay = faults.latency;
  const core::RigidTransform& tissue_from_tracker = config.bundle.tissue_from_tracker;
  const core::RigidTransform back = core::misplaced(faults).inverse(), to_tracker = tissue_from_tracker.inverse();
  config.marker_correction.rotation = to_tracker.rotation * back.rotation * tissue_from_tracker.rotation;
  config.marker_correction.translation = to_tracker(back(tissue_from_tracker(core::Vec3::Zero())));
  for (const core::SlippedMarker& slip : faults.slips)
    if (static_cast<std::size_t>(slip.marker) < scene.markers.size()) scene.markers[slip.marker].rest += slip.shift;
}

}  // namespace tissued::daemon
