#include "core/refined_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace tissued::core {

namespace {

using Edge = std::pair<int, int>;

constexpr double kSmooth = 0.7;         // cosine of the angle up to which neighbouring facets are one smooth surface
constexpr double kSameSide = 0.3;       // likewise, up to which facets around a node share its normal
constexpr double kGentleTurn = 0.6;     // the same of the edges of a curve between groups
constexpr double kLargestOffset = 0.2;  // of an edge's length

Edge edge_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

// Numbers the middle of an edge once.
class Middles {
 public:
  explicit Middles(int nodes) : next_(nodes) {}
  int of(int a, int b) {
    const auto [at, is_new] = index_.try_emplace(edge_of(a, b), next_);
    if (is_new) ++next_;
    return at->second;
  }
  const std::map<Edge, int>& all() const { return index_; }

 private:
  std::map<Edge, int> index_;
  int next_;
};

// The facets of the boundary, by node and by edge.
class Skin {
 public:
  explicit Skin(const TetMesh& mesh) : mesh_(&mesh) {
    std::map<std::array<int, 3>, int> group_of;
    for (std::size_t g = 0; g < mesh.surfaces.size(); ++g)
      for (Triangle t : mesh.surfaces[g].triangles) {
        std::sort(t.begin(), t.end());
        group_of[t] = static_cast<int>(g);
      }
    for (const Triangle& t : boundary_of(mesh)) {
      Triangle sorted = t;
      std::sort(sorted.begin(), sorted.end());
      const auto group = group_of.find(sorted);
      const int facet = static_cast<int>(facets_.size());
      facets_.push_back({(mesh.node(t[1]) - mesh.node(t[0])).cross(mesh.node(t[2]) - mesh.node(t[0])),
                         group == group_of.end() ? -1 : group->second});
      for (int k = 0; k < 3; ++k) {
        of_edge_[edge_of(t[k], t[(k + 1) % 3])].push_back(facet);
        of_node_[t[k]].push_back(facet);
      }
    }
    for (const auto& [edge, facets] : of_edge_) {
      if (is_smooth(facets)) continue;
      rims_[edge.first].push_back(edge);
      rims_[edge.second].push_back(edge);
    }
  }

  // Where the middle of an edge belongs; nothing for an edge inside of the body.
  bool place(const Edge& edge, Vec3& middle) const {
    const auto facets = of_edge_.find(edge);
    if (facets == of_edge_.end()) return false;
    const Vec3 a = mesh_->node(edge.first), b = mesh_->node(edge.second);
    Vec3 offset = is_smooth(facets->second) ? offset_of_surface(edge, facets->second) : offset_of_rim(edge);
    const double limit = kLargestOffset * (b - a).norm();
    if (offset.norm() > limit) offset *= limit / offset.norm();
    middle = 0.5 * (a + b) + offset;
    return true;
  }

 private:
  struct Facet {
    Vec3 area;  // normal, as long as twice the area
    int group;
  };

  bool is_smooth(const std::vector<int>& facets) const {
    if (facets.size() != 2) return false;
    const Facet &a = facets_[facets[0]], &b = facets_[facets[1]];
    return a.group == b.group && a.area.normalized().dot(b.area.normalized()) > kSmooth;
  }

  // Normal at a node of the smooth surface that the facets of the edge belong to.
  Vec3 normal_at(int node, const Vec3& near, int group) const {
    Vec3 sum = Vec3::Zero();
    for (int facet : of_node_.at(node))
      if (facets_[facet].group == group && facets_[facet].area.normalized().dot(near) > kSameSide)
        sum += facets_[facet].area;
    return sum.norm() > 0.0 ? Vec3(sum.normalized()) : near;
  }

  // Middle of the cubic whose ends are tangential to the surface.
  Vec3 offset_of_surface(const Edge& edge, const std::vector<int>& facets) const {
    const Vec3 near = (facets_[facets[0]].area + facets_[facets[1]].area).normalized();
    const int group = facets_[facets[0]].group;
    const Vec3 along = mesh_->node(edge.second) - mesh_->node(edge.first);
    const Vec3 first = normal_at(edge.first, near, group), second = normal_at(edge.second, near, group);
    return 0.125 * (along.dot(second) * second - along.dot(first) * first);
  }

  // Middle of the cubic through the ends and their neighbours on the curve; straight where it turns sharply or
  // branches.
  Vec3 offset_of_rim(const Edge& edge) const {
    const auto beyond = [&](int end, int other) {
      const std::vector<Edge>& edges = rims_.at(end);
      if (edges.size() != 2) return -1;
      const Edge& next = edges[0] == edge ? edges[1] : edges[0];
      const int node = next.first == end ? next.second : next.first;
      const Vec3 in = (mesh_->node(end) - mesh_->node(other)).normalized();
      const Vec3 out = (mesh_->node(node) - mesh_->node(end)).normalized();
      return in.dot(out) > kGentleTurn ? node : -1;
    };
    const int before = beyond(edge.first, edge.second), after = beyond(edge.second, edge.first);
    if (before < 0 || after < 0) return Vec3::Zero();
    const Vec3 a = mesh_->node(edge.first), b = mesh_->node(edge.second);
    return (a + b - mesh_->node(before) - mesh_->node(after)) / 16.0;
  }

  const TetMesh* mesh_;
  std::vector<Facet> facets_;
  std::map<Edge, std::vector<int>> of_edge_;
  std::map<int, std::vector<int>> of_node_;
  std::map<int, std::vector<Edge>> rims_;  // edges that are not smooth, by node
};

// The four corners and the octahedron between them, cut along its shortest diagonal.
void split(const Tet& tet, const std::array<int, 6>& m, const TetMesh& mesh, std::vector<Tet>& out) {
  const auto [ab, bc, ca, ad, bd, cd] = m;
  out.push_back({tet[0], ab, ca, ad});
  out.push_back({ab, tet[1], bc, bd});
  out.push_back({ca, bc, tet[2], cd});
  out.push_back({ad, bd, cd, tet[3]});
  const auto length = [&](int a, int b) { return (mesh.node(a) - mesh.node(b)).squaredNorm(); };
  const double first = length(ab, cd), second = length(bc, ad), third = length(ca, bd);
  // The diagonal's ends, and the four nodes around it in order.
  int top = ab, bottom = cd;
  std::array<int, 4> ring{ca, ad, bd, bc};
  if (second <= first && second <= third) {
    top = bc, bottom = ad;
    ring = {ab, bd, cd, ca};
  } else if (third <= first && third <= second) {
    top = ca, bottom = bd;
    ring = {ab, bc, cd, ad};
  }
  for (int k = 0; k < 4; ++k) {
    Tet piece{top, bottom, ring[k], ring[(k + 1) % 4]};
    if (signed_volume(mesh, piece) < 0.0) std::swap(piece[2], piece[3]);
    out.push_back(piece);
  }
}

}  // namespace

TetMesh refined(const TetMesh& mesh) {
  Middles middles(mesh.node_count());
  std::vector<std::array<int, 6>> of_tet;
  for (const Tet& t : mesh.tets)
    of_tet.push_back({middles.of(t[0], t[1]), middles.of(t[1], t[2]), middles.of(t[2], t[0]), middles.of(t[0], t[3]),
                      middles.of(t[1], t[3]), middles.of(t[2], t[3])});
  TetMesh out;
  out.rest.resize(mesh.node_count() + static_cast<Eigen::Index>(middles.all().size()), 3);
  out.rest.topRows(mesh.node_count()) = mesh.rest;
  for (const auto& [edge, node] : middles.all())
    out.rest.row(node) = 0.5 * (mesh.rest.row(edge.first) + mesh.rest.row(edge.second));
  for (int t = 0; t < mesh.tet_count(); ++t) split(mesh.tets[t], of_tet[t], out, out.tets);
  for (const SurfaceGroup& group : mesh.surfaces) {
    out.surfaces.push_back({group.name, {}});
    std::vector<Triangle>& pieces = out.surfaces.back().triangles;
    for (const Triangle& t : group.triangles) {
      const int ab = middles.of(t[0], t[1]), bc = middles.of(t[1], t[2]), ca = middles.of(t[2], t[0]);
      pieces.insert(pieces.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
    }
  }
  // Onto the smooth surface, as far as no tetrahedron suffers.
  const Skin skin(mesh);
  std::vector<std::vector<int>> tets_of(static_cast<std::size_t>(out.node_count()));
  for (int t = 0; t < out.tet_count(); ++t)
    for (int node : out.tets[t]) tets_of[node].push_back(t);
  for (const auto& [edge, node] : middles.all()) {
    Vec3 place;
    if (!skin.place(edge, place)) continue;
    const Vec3 straight = out.node(node);
    std::vector<double> before;
    for (int t : tets_of[node]) before.push_back(signed_volume(out, out.tets[t]));
    out.rest.row(node) = place.transpose();
    constexpr double kLeastShare = 0.3;  // of its volume that a tetrahedron must keep
    for (std::size_t k = 0; k < before.size(); ++k) {
      if (signed_volume(out, out.tets[tets_of[node][k]]) > kLeastShare * before[k]) continue;
      out.rest.row(node) = straight.transpose();
      break;
    }
  }
  return out;
}

}  // namespace tissued::core
