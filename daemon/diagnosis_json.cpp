#include "daemon/diagnosis_json.hpp"

#include <cmath>

namespace tissued::daemon {
namespace {

using nlohmann::json;

void put(json& object, const char* key, double value) {
  if (std::isfinite(value)) object[key] = value;
}

// One number as itself, several as an array.
void put(json& object, const char* key, const std::vector<double>& values) {
  if (values.size() == 1) {
    put(object, key, values.front());
  } else if (!values.empty()) {
    object[key] = values;
  }
}

json place_json(const std::optional<core::Finding::Place>& place) {
  if (!place) return nullptr;
  json where{{"center", {place->center.x(), place->center.y(), place->center.z()}}};
  put(where, "radius", place->radius);
  return where;
}

// By the contract: which markers, and how far; of several a shift each.
json slip_json(const core::Finding& finding) {
  json markers = json::array(), shifts = json::array(), sds = json::array();
  for (const core::FindingNumber& number : finding.parameters) {
    markers.push_back(number.name);
    shifts.push_back(number.value);
    sds.push_back(number.sd);
  }
  if (markers.size() == 1) {
    shifts = json(shifts[0]);
    sds = json(sds[0]);
  }
  return {{"markers", {{"value", markers}}}, {"shift", {{"value", shifts}, {"sd", sds}, {"unit", "mm"}}}};
}

json parameters_json(const core::Finding& finding) {
  if (finding.kind == "marker-slip") return slip_json(finding);
  json parameters = json::object();
  for (const core::FindingNumber& number : finding.parameters) {
    json& entry = parameters[number.name] = {{"unit", number.unit}};
    put(entry, "value", number.value);
    put(entry, "sd", number.sd);
  }
  return parameters;
}

json finding_json(const core::Finding& finding) {
  json when{{"trials", finding.trials}};
  if (!finding.phase.empty()) when["phase"] = finding.phase;
  json out{{"kind", finding.kind},
           {"summary", finding.summary},
           {"where", place_json(finding.where)},
           {"when", when},
           {"parameters", parameters_json(finding)}};
  put(out, "probability", finding.probability);
  return out;
}

json misfit_json(const core::Misfit& misfit) {
  json out = json::object();
  put(out, "marker_rms", misfit.marker_mm);
  put(out, "force_rms", misfit.force_N);
  put(out, "target_rms", misfit.target_mm);
  return out;
}

json misfits_json(const core::Misfits& misfits) {
  return {{"assumed", misfit_json(misfits.assumed)},
          {"parameters", misfit_json(misfits.parameters)},
          {"explained", misfit_json(misfits.explained)}};
}

double root_mean_square(const std::vector<double>& values) {
  double square = 0.0, count = 0.0;
  for (double value : values)
    if (std::isfinite(value)) {
      square += value * value;
      count += 1.0;
    }
  return std::sqrt(square / count);
}

json course_json(const core::TrialCourse& course) {
  json out{{"trial", course.name}, {"held_out", course.held_out}};
  put(out, "assumed_marker_rms", root_mean_square(course.assumed_mm));
  put(out, "parameters_marker_rms", root_mean_square(course.parameters_mm));
  put(out, "explained_marker_rms", root_mean_square(course.explained_mm));
  return out;
}

json fit_json(const core::Diagnosis& diagnosis) {
  constexpr core::Misfit kUnseen{NAN, NAN, NAN};
  json floor = json::object(), discretisation = json::object();
  put(floor, "marker", diagnosis.noise_marker_mm);
  put(floor, "force", diagnosis.noise_force_N);
  put(discretisation, "marker_rms", diagnosis.discretisation_marker_mm);
  return {{"trials", misfits_json(diagnosis.trials)},
          {"held_out",
           misfits_json(diagnosis.held_out_seen ? diagnosis.held_out : core::Misfits{kUnseen, kUnseen, kUnseen})},
          {"noise_floor", floor},
          {"discretisation", discretisation}};
}

}  // namespace

json report_json(const core::Diagnosis& diagnosis) {
  json findings = json::array(), alternatives = json::array();
  for (const core::Finding& finding : diagnosis.findings) findings.push_back(finding_json(finding));
  for (const core::Alternative& alternative : diagnosis.alternatives) {
    json& entry = alternatives.emplace_back(json{{"kind", alternative.kind}});
    put(entry, "probability", alternative.probability);
  }
  json report{
      {"format", "tissue-diagnosis/1"}, {"bundle", diagnosis.bundle},     {"verdict", core::name_of(diagnosis.verdict)},
      {"findings", findings},           {"alternatives", alternatives},   {"fit", fit_json(diagnosis)},
      {"next_experiment", nullptr},     {"complete", diagnosis.complete}, {"remarks", diagnosis.remarks}};
  for (const core::TrialCourse& course : diagnosis.courses) report["each_trial"].push_back(course_json(course));
  if (!diagnosis.next_experiment.empty()) report["next_experiment"] = diagnosis.next_experiment;
  put(report, "seconds", diagnosis.seconds);
  return report;
}

}  // namespace tissued::daemon
