#include "daemon/body_slices.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/html.hpp"
#include "daemon/mismatch_colours.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

using core::Vec3;

constexpr double kWidth = 340, kMargin = 26;  // px
constexpr double kTargetReach = 10.0;         // mm: targets as far from the cut as this are drawn
constexpr std::array kBands{0.2, 0.35, 0.5, 0.65, 0.8, 0.92};
constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};

// A plane across an axis, and how it is drawn: which axes go to the right and up.
struct Cut {
  int across, right, up;
  const char* seen_from;
  double at;  // mm
};

struct CutPoint {
  double right, up;  // mm
  double value;
};
using Polygon = std::vector<CutPoint>;

// Where a drawing has what, px.
struct Sheet {
  Vec3 low, high;
  double scale;
  Cut cut;

  double x(double right) const { return kMargin + scale * (right - low[cut.right]); }
  double y(double up) const { return kMargin + 18.0 + scale * (high[cut.up] - up); }
  double height() const { return y(low[cut.up]) + kMargin + 20.0; }
};

CutPoint crossing(const core::TetMesh& mesh, const std::vector<double>& values, const Cut& cut, int a, int b) {
  const Vec3 from = mesh.node(a), to = mesh.node(b);
  const double share = (cut.at - from[cut.across]) / (to[cut.across] - from[cut.across]);
  const Vec3 point = from + share * (to - from);
  return {point[cut.right], point[cut.up], values[a] + share * (values[b] - values[a])};
}

// Where the plane crosses the edges between nodes on its two sides.
template <std::size_t count>
Polygon crossings(const core::TetMesh& mesh, const std::vector<double>& values, const Cut& cut,
                  const std::array<int, count>& nodes) {
  Polygon polygon;
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a + 1; b < count; ++b) {
      if ((mesh.rest(nodes[a], cut.across) < cut.at) == (mesh.rest(nodes[b], cut.across) < cut.at)) continue;
      polygon.push_back(crossing(mesh, values, cut, nodes[a], nodes[b]));
    }
  }
  return polygon;
}

// Counter-clockwise around its middle.
void arrange(Polygon& polygon) {
  CutPoint middle{};
  for (const CutPoint& point : polygon) {
    middle.right += point.right / static_cast<double>(polygon.size());
    middle.up += point.up / static_cast<double>(polygon.size());
  }
  std::ranges::sort(polygon, {},
                    [&](const CutPoint& p) { return std::atan2(p.up - middle.up, p.right - middle.right); });
}

std::vector<Polygon> cut_polygons(const core::TetMesh& mesh, const std::vector<double>& values, const Cut& cut) {
  std::vector<Polygon> polygons;
  for (const core::Tet& tet : mesh.tets) {
    Polygon polygon = crossings(mesh, values, cut, tet);
    if (polygon.size() < 3) continue;
    arrange(polygon);
    polygons.push_back(std::move(polygon));
  }
  return polygons;
}

// The part of a convex polygon where the value is not below `least` (Sutherland and Hodgman).
Polygon clipped(const Polygon& polygon, double least) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const CutPoint& a = polygon[i];
    const CutPoint& b = polygon[(i + 1) % polygon.size()];
    if (a.value >= least) kept.push_back(a);
    if ((a.value >= least) == (b.value >= least)) continue;
    const double share = (least - a.value) / (b.value - a.value);
    kept.push_back({a.right + share * (b.right - a.right), a.up + share * (b.up - a.up), least});
  }
  return kept;
}

std::string px(double value) { return fixed(value, 1); }

std::string path_of(const Sheet& sheet, const Polygon& polygon) {
  std::string path;
  for (const CutPoint& point : polygon) {
    path += path.empty() ? 'M' : 'L';
    path += px(sheet.x(point.right)) + ' ' + px(sheet.y(point.up));
  }
  return path;
}

std::string colour(double share) {
  const double at = share * static_cast<double>(kMismatchColours.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), kMismatchColours.size() - 2);
  std::string text = "rgb(";
  for (std::size_t c = 0; c < 3; ++c) {
    const double value =
        std::lerp(kMismatchColours[low][c], kMismatchColours[low + 1][c], at - static_cast<double>(low));
    if (c > 0) text += ',';
    text += std::to_string(std::lround(value));
  }
  return text + ')';
}

// One path for all polygons of a band: they share edges, which would show where each were painted by itself.
std::string bands(const Sheet& sheet, const std::vector<Polygon>& polygons) {
  std::string out, whole;
  for (const Polygon& polygon : polygons) whole += path_of(sheet, polygon) + "Z";
  out += "<path class=\"inside\" d=\"" + whole + "\"/>\n";
  for (std::size_t b = 0; b < kBands.size(); ++b) {
    std::string band;
    for (const Polygon& polygon : polygons) {
      const Polygon part = clipped(polygon, kBands[b]);
      if (part.size() >= 3) band += path_of(sheet, part) + "Z";
    }
    const std::string paint = colour(static_cast<double>(b) / static_cast<double>(kBands.size() - 1));
    if (!band.empty())
      out += "<path style=\"fill:" + paint + ";stroke:" + paint + "\" class=\"band\" d=\"" + band + "\"/>\n";
  }
  return out;
}

// Where the cut crosses facets: one line for each.
std::vector<Polygon> segments(const core::TetMesh& mesh, const std::vector<core::Triangle>& facets, const Cut& cut) {
  const std::vector<double> none(static_cast<std::size_t>(mesh.node_count()), 0.0);
  std::vector<Polygon> lines;
  for (const core::Triangle& facet : facets) {
    Polygon segment = crossings(mesh, none, cut, facet);
    if (segment.size() == 2) lines.push_back(std::move(segment));
  }
  return lines;
}

std::string outline(const Sheet& sheet, const std::vector<Polygon>& lines, const std::string& kind) {
  std::string path;
  for (const Polygon& segment : lines) path += path_of(sheet, segment);
  return path.empty() ? "" : "<path class=\"" + kind + "\" d=\"" + path + "\"/>\n";
}

std::string word(double x, double y, const std::string& text, const std::string& kind) {
  return "<text class=\"" + kind + "\" x=\"" + px(x) + "\" y=\"" + px(y) + "\">" + escape_html(text) + "</text>\n";
}

// The name of what the cut shows as `lines`, beside their middle, away from the body's.
std::string name_beside(const Sheet& sheet, const std::vector<Polygon>& lines, const std::string& name) {
  double right = 0.0, up = 0.0;
  for (const Polygon& segment : lines) {
    right += 0.5 * (segment[0].right + segment[1].right) / static_cast<double>(lines.size());
    up += 0.5 * (segment[0].up + segment[1].up) / static_cast<double>(lines.size());
  }
  const Vec3 middle = 0.5 * (sheet.low + sheet.high);
  const double to_right = right - middle[sheet.cut.right], to_up = up - middle[sheet.cut.up];
  const bool beside = std::abs(to_right) >= std::abs(to_up);
  const double x = sheet.x(right) + (!beside ? 0.0 : to_right > 0.0 ? 9.0 : -9.0);
  const double y = sheet.y(up) + (beside ? 4.0 : to_up > 0.0 ? -9.0 : 18.0);
  return word(x, y, name, !beside ? "pad middle" : to_right > 0.0 ? "pad" : "pad end");
}

std::string named_surfaces(const Sheet& sheet, const core::Scene& scene) {
  std::string out = outline(sheet, segments(scene.mesh, core::boundary_of(scene.mesh), sheet.cut), "rind");
  if (const auto* base = scene.mesh.find_surface(scene.fixed_surface)) {
    out += outline(sheet, segments(scene.mesh, base->triangles, sheet.cut), "rind base");
  }
  for (const core::Pad& pad : scene.pads) {
    const core::SurfaceGroup* surface = scene.mesh.find_surface(pad.surface);
    if (surface == nullptr) continue;
    const std::vector<Polygon> lines = segments(scene.mesh, surface->triangles, sheet.cut);
    if (!lines.empty()) out += outline(sheet, lines, "rind pad") + name_beside(sheet, lines, pad.name);
  }
  return out;
}

std::string targets(const Sheet& sheet, const core::Scene& scene) {
  std::string out;
  for (const core::Target& target : scene.targets) {
    if (std::abs(target.rest[sheet.cut.across] - sheet.cut.at) > kTargetReach) continue;
    const double x = sheet.x(target.rest[sheet.cut.right]), y = sheet.y(target.rest[sheet.cut.up]);
    out += "<path class=\"target\" d=\"M" + px(x - 4) + " " + px(y) + "h8M" + px(x) + " " + px(y - 4) + "v8\"/>\n" +
           word(x + 6, y + 12, target.name, "target");
  }
  return out;
}

std::string places(const Sheet& sheet, const core::Diagnosis& diagnosis) {
  std::string out;
  for (const core::Finding& finding : diagnosis.findings) {
    if (!finding.where) continue;
    const double away = finding.where->center[sheet.cut.across] - sheet.cut.at, radius = finding.where->radius;
    if (!(std::abs(away) < radius)) continue;
    out += "<circle class=\"place\" cx=\"" + px(sheet.x(finding.where->center[sheet.cut.right])) + "\" cy=\"" +
           px(sheet.y(finding.where->center[sheet.cut.up])) + "\" r=\"" +
           px(sheet.scale * std::sqrt(radius * radius - away * away)) + "\"/>\n";
  }
  return out;
}

std::string slice(const core::Diagnosis& diagnosis, const core::Scene& scene, const std::vector<double>& mismatch,
                  const Cut& cut) {
  Sheet sheet{scene.mesh.rest.colwise().minCoeff(), scene.mesh.rest.colwise().maxCoeff(), 0.0, cut};
  const Vec3 extent = sheet.high - sheet.low;
  sheet.scale = (kWidth - 2.0 * kMargin) / std::max(extent.x(), extent.y());
  const std::string title =
      std::string("From ") + cut.seen_from + ", cut at " + kAxes[cut.across] + " = " + fixed(cut.at, 0) + " mm";
  std::string out = word(kWidth / 2, 14, title, "title middle");
  out += bands(sheet, cut_polygons(scene.mesh, mismatch, cut)) + named_surfaces(sheet, scene);
  out += targets(sheet, scene) + places(sheet, diagnosis);
  const double foot = sheet.height() - 8.0;
  out += "<path class=\"rule\" d=\"M" + px(kMargin) + " " + px(foot - 4) + "v4h" + px(20.0 * sheet.scale) +
         "v-4\"/>\n" + word(kMargin + 20.0 * sheet.scale + 6.0, foot, "20 mm", "tick") +
         word(kWidth - kMargin, foot, std::string("right ") + kAxes[cut.right] + ", up " + kAxes[cut.up], "tick end");
  return "<svg class=\"slice\" viewBox=\"0 0 " + px(kWidth) + " " + px(sheet.height()) +
         "\" role=\"img\" aria-label=\"" + title + "\">\n" + out + "</svg>\n";
}

}  // namespace

std::string body_slices(const core::Diagnosis& diagnosis, const core::Scene& scene, const std::vector<double>& mismatch,
                        const core::Vec3& through) {
  const std::array<Cut, 3> cuts{Cut{2, 0, 1, "above", through.z()}, Cut{1, 0, 2, "the front", through.y()},
                                Cut{0, 1, 2, "the side", through.x()}};
  std::string panels;
  for (const Cut& cut : cuts) panels += slice(diagnosis, scene, mismatch, cut);
  return element("div", panels, "class=\"panels slices\"");
}

}  // namespace tissued::daemon
