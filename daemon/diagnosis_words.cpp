#include "daemon/diagnosis_words.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "core/effects/effect.hpp"
#include "daemon/html.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

using core::Vec3;
using core::Verdict;

constexpr double kSaid = 0.5;  // a finding less probable than this is not part of the headline

std::string begun_small(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return text;
}

// Titles of the findings; numbers that differ are named only where nothing else is.
std::string titles(const core::Diagnosis& diagnosis) {
  std::vector<std::string> said;
  for (const bool numbers : {false, true}) {
    for (const core::Finding& finding : diagnosis.findings) {
      if ((finding.kind == "parameters") != numbers || finding.probability < kSaid || finding.title.empty()) continue;
      if (!numbers || said.empty()) said.push_back(escape_html(finding.title));
    }
  }
  std::string text;
  for (std::size_t i = 0; i < said.size(); ++i) {
    text += i == 0 ? said[i] : (i + 1 == said.size() ? ", and " : ", ") + begun_small(said[i]);
  }
  return text;
}

// The nearest of some named points.
struct Nearest {
  std::string name;
  double distance = INFINITY;  // mm

  void offer(const std::string& other, const Vec3& from, const Vec3& to) {
    if (const double away = (to - from).norm(); away < distance) *this = {other, away};
  }
};

double depth_below_skin(const core::Scene& scene, const Vec3& position) {
  std::vector<core::Triangle> facets;
  const auto add = [&](const std::string& name) {
    if (const core::SurfaceGroup* group = scene.mesh.find_surface(name)) {
      facets.insert(facets.end(), group->triangles.begin(), group->triangles.end());
    }
  };
  add(scene.skin_surface);
  for (const core::Pad& pad : scene.pads) add(pad.surface);
  return core::locate_on_surface(scene.mesh, facets, position).distance;
}

// Decimals at which a standard deviation has one digit that counts, two where the first is a 1 or a 2.
int digits_for(double sd) {
  const double power = std::floor(std::log10(sd));
  const bool leads_small = sd / std::pow(10.0, power) < 2.95;
  return std::clamp(static_cast<int>(-power) + (leads_small ? 1 : 0), 0, 8);
}

}  // namespace

std::string percent_text(double probability) {
  if (!std::isfinite(probability)) return "–";
  if (probability >= 0.995) return "over 99 %";
  if (probability < 0.001) return "under 0.1 %";
  return fixed(100.0 * probability, probability < 0.0995 ? 1 : 0) + " %";
}

std::string verdict_text(const core::Diagnosis& diagnosis) {
  switch (diagnosis.verdict) {
    case Verdict::no_mismatch:
      return "Nothing is wrong";
    case Verdict::parameters:
      return "The physics is right, its numbers are not";
    case Verdict::measurement:
      return "The recording is at fault, the physics is not";
    case Verdict::missing_physics:
      return "The simulation leaves physics out";
    case Verdict::unexplained:
      break;
  }
  return "Something is missing that has no name here";
}

std::string headline(const core::Diagnosis& diagnosis) {
  if (diagnosis.verdict == Verdict::no_mismatch) return "The simulation explains what was recorded";
  const std::string said = titles(diagnosis);
  if (!said.empty()) return said;
  return diagnosis.verdict == Verdict::unexplained
             ? "The simulation disagrees with what was recorded, and nothing that this program knows explains it"
             : "The simulation disagrees with what was recorded";
}

std::string sureness_text(const core::Diagnosis& diagnosis) {
  if (diagnosis.verdict != Verdict::no_mismatch) {
    std::string text;
    for (const core::Finding& finding : diagnosis.findings) {
      if (finding.probability < kSaid) continue;
      text += (text.empty() ? "" : "; ") + percent_text(finding.probability) + " sure";
      if (diagnosis.findings.size() > 1) text += " of " + escape_html(finding.kind);
    }
    return text;
  }
  const auto likeliest = std::ranges::max_element(diagnosis.alternatives, {}, &core::Alternative::probability);
  if (likeliest == diagnosis.alternatives.end()) return {};
  return "No fault is likelier than " + percent_text(likeliest->probability) + " (" + escape_html(likeliest->kind) +
         ")";
}

std::string place_text(const core::Finding& finding, const core::Scene& scene) {
  if (!finding.where || !finding.where->center.allFinite()) return {};
  const Vec3& center = finding.where->center;
  std::string text;
  // The summary speaks of a center that was fitted.
  if (std::ranges::find(finding.parameters, "center", &core::FindingNumber::name) == finding.parameters.end()) {
    text = "Around (" + fixed(center.x(), 0) + ", " + fixed(center.y(), 0) + ", " + fixed(center.z(), 0) +
           ") mm, within " + fixed(finding.where->radius, 0) + " mm; ";
  }
  const double depth = depth_below_skin(scene, center);
  text += fixed(depth, 0) + " mm from the skin";
  Nearest pad, target;
  for (const core::Pad& other : scene.pads) pad.offer(other.name, center, other.center);
  for (const core::Target& other : scene.targets) target.offer(other.name, center, other.rest);
  if (!pad.name.empty()) text += ", " + fixed(pad.distance, 0) + " mm from pad " + escape_html(pad.name);
  if (!target.name.empty()) text += ", " + fixed(target.distance, 0) + " mm from target " + escape_html(target.name);
  return text + ".";
}

std::string time_text(const core::Finding& finding) {
  std::string text;
  for (const std::string& trial : finding.trials) text += (text.empty() ? "" : ", ") + escape_html(trial);
  if (!text.empty()) text = "Shows most in " + text;
  if (!finding.phase.empty()) {
    const std::string phase = finding.phase == "throughout" ? "throughout" : "during the " + escape_html(finding.phase);
    text += text.empty() ? "Shows most " + phase : ", " + phase;
  }
  return text.empty() ? text : text + ".";
}

std::string kind_text(const std::string& kind) {
  std::string names, words;
  constexpr std::string_view kJoin = " + ";
  for (std::size_t from = 0; from <= kind.size();) {
    const std::size_t to = std::min(kind.find(kJoin, from), kind.size());
    const std::string one = kind.substr(from, to - from);
    names += (names.empty() ? "" : " + ") + escape_html(one);
    if (const core::Effect* effect = core::find_effect(one)) {
      const std::string title(effect->title());
      words += words.empty() ? title : ", and " + begun_small(title);
    }
    from = to + kJoin.size();
  }
  return element("b", names) + (words.empty() ? "" : element("span", escape_html(words), "class=\"words\""));
}

std::string number_text(const core::FindingNumber& number) {
  std::string text;
  for (std::size_t i = 0; i < number.value.size(); ++i) {
    const double value = number.value[i], sd = i < number.sd.size() ? number.sd[i] : NAN;
    if (i > 0) text += ", ";
    if (std::isfinite(value) && std::isfinite(sd) && sd > 0.0) {
      const int digits = digits_for(sd);
      text += fixed(value, digits) + " ± " + fixed(sd, digits);
    } else {
      char plain[32];
      std::snprintf(plain, sizeof plain, "%.4g", value);
      text += std::isfinite(value) ? plain : "–";
    }
  }
  return text;
}

}  // namespace tissued::daemon
