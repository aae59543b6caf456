#include "daemon/body_view.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "daemon/body_view_script.hpp"
#include "daemon/html.hpp"
#include "daemon/mismatch_colours.hpp"
#include "daemon/mismatch_field.hpp"

namespace tissued::daemon {
namespace {

using core::Vec3;
using nlohmann::json;

constexpr int kCells = 44;                // of the mismatch grid along the longest side
constexpr double kLongestArrow = 0.28;    // at first, of the body's radius
constexpr double kMostExaggeration = 30;  // at first: what is a hundredth of a body is not made to look like a lot
constexpr double kSliderEnd = 100.0;      // of the exaggeration: 10^(value / 50)

json rounded(const Vec3& position) {
  const auto hundredths = [](double value) { return std::round(100.0 * value) / 100.0; };
  return {hundredths(position.x()), hundredths(position.y()), hundredths(position.z())};
}

// null where it was not seen.
json displacement(const Vec3& by) { return by.allFinite() ? json{by.x(), by.y(), by.z()} : json(); }

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr const char* kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned word = 0;
    for (std::size_t b = 0; b < 3; ++b) word = (word << 8) | (i + b < bytes.size() ? bytes[i + b] : 0u);
    for (int shift = 18; shift >= 0; shift -= 6) text += kAlphabet[(word >> shift) & 63u];
    if (i + 1 >= bytes.size()) text[text.size() - 2] = '=';
    if (i + 2 >= bytes.size()) text.back() = '=';
  }
  return text;
}

// Nodes of the base are apart from those of the skin, so that its rim is an edge when normals are smoothed.
void add_surface(json& data, const core::Scene& scene) {
  enum Group { skin = 0, pad = 1, base = 2 };
  std::map<core::Triangle, Group> groups;
  const auto sorted = [](core::Triangle triangle) {
    std::ranges::sort(triangle);
    return triangle;
  };
  const auto mark = [&](const std::string& name, Group group) {
    const core::SurfaceGroup* surface = scene.mesh.find_surface(name);
    if (surface == nullptr) return;
    for (const core::Triangle& triangle : surface->triangles) groups[sorted(triangle)] = group;
  };
  mark(scene.fixed_surface, base);
  for (const core::Pad& held : scene.pads) mark(held.surface, pad);
  json points = json::array(), triangles = json::array(), of_triangle = json::array();
  std::map<std::pair<int, bool>, int> corners;
  for (const core::Triangle& triangle : core::boundary_of(scene.mesh)) {
    const auto group = groups.find(sorted(triangle));
    of_triangle.push_back(group == groups.end() ? skin : group->second);
    for (const int node : triangle) {
      const auto [corner, fresh] =
          corners.try_emplace({node, of_triangle.back() == base}, static_cast<int>(corners.size()));
      triangles.push_back(corner->second);
      if (!fresh) continue;
      for (const json& coordinate : rounded(scene.mesh.node(node))) points.push_back(coordinate);
    }
  }
  data["points"] = points;
  data["triangles"] = triangles;
  data["groups"] = of_triangle;
}

void add_middle(json& data, const core::Scene& scene) {
  const Vec3 low = scene.mesh.rest.colwise().minCoeff(), high = scene.mesh.rest.colwise().maxCoeff();
  const Vec3 middle = 0.5 * (low + high);
  data["middle"] = rounded(middle);
  data["radius"] = std::sqrt((scene.mesh.rest.rowwise() - middle.transpose()).rowwise().squaredNorm().maxCoeff());
}

void add_named(json& data, const core::Scene& scene) {
  data["pads"] = data["targets"] = data["markers"] = json::array();
  for (const core::Pad& pad : scene.pads) data["pads"].push_back({{"name", pad.name}, {"center", rounded(pad.center)}});
  for (const core::Target& target : scene.targets) {
    data["targets"].push_back({{"name", target.name}, {"at", rounded(target.rest)}});
  }
  for (const core::Marker& marker : scene.markers) {
    data["markers"].push_back({{"name", marker.name}, {"rest", rounded(marker.rest)}});
  }
}

// Seen first from the side on which the first place lies.
void add_places(json& data, const core::Diagnosis& diagnosis) {
  data["places"] = json::array();
  data["yaw"] = -0.9;
  for (const core::Finding& finding : diagnosis.findings) {
    if (!finding.where || !finding.where->center.allFinite() || !std::isfinite(finding.where->radius)) continue;
    const Vec3& center = finding.where->center;
    if (data["places"].empty()) data["yaw"] = std::atan2(center.y(), center.x()) - 0.7;
    data["places"].push_back({{"center", rounded(center)}, {"radius", finding.where->radius}, {"label", finding.kind}});
  }
}

void add_map(json& data, const core::Scene& scene, const std::vector<double>& mismatch) {
  data["map"] = nullptr;
  data["colours"] = kMismatchColours;
  if (mismatch.empty()) return;
  const MismatchGrid grid = mismatch_grid(scene.mesh, mismatch, kCells);
  data["map"] = {{"size", grid.size},
                 {"origin", {grid.origin.x(), grid.origin.y(), grid.origin.z()}},
                 {"spacing", grid.spacing},
                 {"values", base64(grid.values)}};
}

// The trials' markers, in the order in which trials come; the trial whose markers are missed most is shown first.
struct ShownTrials {
  std::vector<std::string> names;
  std::size_t first = 0;
  double longest = 0.0, most_left = 0.0;  // mm: seen displacement, and what the assumed model misses of it
};

ShownTrials add_trials(json& data, const core::Diagnosis& diagnosis) {
  ShownTrials shown;
  std::vector<double> squares;
  data["trials"] = json::array();
  for (const core::MarkerMisfit& marker : diagnosis.markers) {
    const auto name = std::ranges::find(shown.names, marker.trial);
    const auto trial = static_cast<std::size_t>(name - shown.names.begin());
    if (name == shown.names.end()) {
      shown.names.push_back(marker.trial);
      squares.push_back(0.0);
      data["trials"].push_back({{"markers", json::array()}});
    }
    if (!marker.rest.allFinite()) continue;
    data["trials"][trial]["markers"].push_back({{"name", marker.marker},
                                                {"rest", rounded(marker.rest)},
                                                {"seen", displacement(marker.seen)},
                                                {"assumed", displacement(marker.assumed)},
                                                {"explained", displacement(marker.explained)}});
    if (!marker.seen.allFinite() || !marker.assumed.allFinite()) continue;
    const double left = (marker.seen - marker.assumed).norm();
    squares[trial] += left * left;
    shown.longest = std::max(shown.longest, marker.seen.norm());
    shown.most_left = std::max(shown.most_left, left);
  }
  if (!squares.empty()) shown.first = static_cast<std::size_t>(std::ranges::max_element(squares) - squares.begin());
  return shown;
}

double exaggeration(double longest, double radius) {
  return longest > 0.0 ? std::clamp(kLongestArrow * radius / longest, 1.0, kMostExaggeration) : 1.0;
}

std::string option(const std::string& value, const std::string& words, bool selected) {
  return element("option", words, "value=\"" + value + "\"" + (selected ? " selected" : ""));
}

std::string slider(const std::string& name, const std::string& words, int low, int high, int value) {
  return element("label", words + "<input type=\"range\" id=\"body-" + name + "\" min=\"" + std::to_string(low) +
                              "\" max=\"" + std::to_string(high) + "\" value=\"" + std::to_string(value) +
                              "\"/><output id=\"body-" + name + "-value\"></output>");
}

std::string controls(const core::Diagnosis& diagnosis, const ShownTrials& shown, double times, bool has_map) {
  std::string trials;
  for (std::size_t i = 0; i < shown.names.size(); ++i) {
    const bool held_out = std::ranges::any_of(diagnosis.courses, [&](const core::TrialCourse& course) {
      return course.held_out && course.name == shown.names[i];
    });
    trials +=
        option(std::to_string(i), escape_html(shown.names[i]) + (held_out ? " (held out)" : ""), i == shown.first);
  }
  const std::string none = shown.names.empty() ? "class=\"absent\"" : "";
  return element(
      "div",
      element("label", "Trial" + element("select", trials, "id=\"body-trial\""), none) +
          element("label",
                  "Arrows" + element("select",
                                     option("left", "what the models miss", true) +
                                         option("whole", "where the markers went", false),
                                     "id=\"body-arrows\""),
                  none) +
          element("div",
                  slider("times", "Arrows drawn", 0, static_cast<int>(kSliderEnd),
                         static_cast<int>(std::lround(50.0 * std::log10(times)))),
                  none) +
          element("div", slider("floor", "Mismatch shown above", 0, 90, 35), has_map ? "" : "class=\"absent\"") +
          element("div",
                  element("button", "Start", "type=\"button\" id=\"body-start\"") +
                      element("button", "Side", "type=\"button\" id=\"body-side\"") +
                      element("button", "Top", "type=\"button\" id=\"body-top\""),
                  "class=\"views\""),
      "class=\"controls\"");
}

std::string key(const core::Diagnosis& diagnosis, bool has_map) {
  const auto entry = [](const char* colour, const char* sign, const std::string& words) {
    return element("li", element("b", sign, std::string("style=\"color:") + colour + "\"") + element("span", words));
  };
  std::string items = entry("var(--fg)", "○", "marker");
  items += entry("var(--fg)", "→", "measured") + entry("var(--c0)", "→", "model as assumed") +
           entry("var(--c1)", "→", "model as explained");
  items += entry("var(--target)", "+", "target") + entry("var(--pad)", "A", "pad");
  if (std::ranges::any_of(diagnosis.findings, [](const auto& finding) { return finding.where.has_value(); })) {
    items += entry("var(--place)", "◯", "place of the finding");
  }
  if (has_map) {
    items += element(
        "li", "<i class=\"ramp\"></i>how much of the misfit other stiffness there would explain, from little to most",
        "class=\"wide\"");
  }
  return element("ul", items, "class=\"legend key\"");
}

}  // namespace

std::string body_view(const core::Diagnosis& diagnosis, const core::Scene& scene, const std::vector<double>& mismatch) {
  json data;
  add_surface(data, scene);
  add_middle(data, scene);
  add_named(data, scene);
  add_places(data, diagnosis);
  add_map(data, scene, mismatch);
  const ShownTrials shown = add_trials(data, diagnosis);
  const double radius = data["radius"];
  data["times_whole"] = exaggeration(shown.longest, radius);
  data["times_left"] = exaggeration(shown.most_left, radius);
  // JSON within a script element must not hold what could end it.
  std::string text = data.dump();
  for (auto at = text.find('<'); at != std::string::npos; at = text.find('<', at)) text.replace(at, 1, "\\u003c");
  const std::string canvas =
      element("canvas", "",
              "id=\"body-canvas\" tabindex=\"0\" role=\"img\" aria-label=\"The body, turnable with the arrow keys\"");
  return element("figure",
                 element("div", canvas, "class=\"stage\"") +
                     element("div",
                             controls(diagnosis, shown, data["times_left"], !mismatch.empty()) +
                                 key(diagnosis, !mismatch.empty()),
                             "class=\"beside\""),
                 "class=\"body\"") +
         element("script", text, "type=\"application/json\" id=\"body-data\"") + element("script", kBodyViewScript);
}

}  // namespace tissued::daemon
