#include "core/fem_solid.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>

namespace tissued::core {

namespace {

constexpr int kRows = 3 * kMostElementNodes;
constexpr int kBlocks = 9 * pair_count(kMostElementNodes);

void gather(const SolidBlock& block, int nodes, const double* x, double* corners) {
  for (int a = 0; a < nodes; ++a)
    for (int axis = 0; axis < 3; ++axis)
      for (int l = 0; l < kPointLanes; ++l) corners[(3 * a + axis) * kPointLanes + l] = x[block.row[a][l] + axis];
}

// (entries x lanes) to one element after the other.
void transpose(const double* lanes, int entries, int elements, double* out) {
  for (int l = 0; l < elements; ++l)
    for (int k = 0; k < entries; ++k) out[static_cast<std::ptrdiff_t>(l) * entries + k] = lanes[k * kPointLanes + l];
}

SolidBlock make_block(const FemMesh& mesh, int first) {
  SolidBlock block{};
  for (int l = 0; l < kPointLanes; ++l) {
    const int element = std::min(first + l, mesh.element_count() - 1);
    const std::span<const int> nodes = mesh.nodes_of_element(element);
    for (std::size_t a = 0; a < nodes.size(); ++a) block.row[a][l] = 3 * static_cast<std::int64_t>(nodes[a]);
    Mat3 edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = (mesh.rest.row(nodes[k + 1]) - mesh.rest.row(nodes[0])).transpose();
    const Mat3 gradients = edges.inverse();
    for (int axis = 0; axis < 3; ++axis) {
      block.gradient[0][axis][l] = -gradients.col(axis).sum();
      for (int k = 0; k < 3; ++k) block.gradient[k + 1][axis][l] = gradients(k, axis);
    }
    block.volume[l] = first + l < mesh.element_count() ? mesh.volumes[element] : 0.0;
  }
  return block;
}

}  // namespace

FemSolid::FemSolid(const FemMesh& mesh, const TetQuadrature& quadrature, std::vector<std::unique_ptr<FemLaw>> laws,
                   std::vector<std::unique_ptr<FemField>> fields)
    : mesh_(&mesh), quadrature_(quadrature), laws_(std::move(laws)), fields_(std::move(fields)) {
  for (int first = 0; first < mesh.element_count(); first += kPointLanes) blocks_.push_back(make_block(mesh, first));
  for (int q = 0; q < quadrature.count(); ++q)
    points_.push_back({mesh.element_nodes(), quadrature.weights[q], shape_slopes(mesh.element, quadrature.points[q])});
  const auto own = [this](FemAdjustable& owner, int law) {
    for (std::size_t k = 0; k < owner.parameters().size(); ++k) {
      parameters_.push_back(owner.parameters()[k]);
      owners_.push_back({&owner, law, static_cast<int>(k)});
    }
  };
  for (std::size_t law = 0; law < laws_.size(); ++law) own(*laws_[law], static_cast<int>(law));
  for (const auto& field : fields_) own(*field, -1);
  multiply_fields();
}

double FemSolid::parameter(int index) const { return owners_[index].owner->parameter(owners_[index].index); }

void FemSolid::set_parameter(int index, double value) {
  owners_[index].owner->set_parameter(owners_[index].index, value);
  if (owners_[index].law < 0) multiply_fields();
}

bool FemSolid::has_derivative(int index) const {
  return owners_[index].law >= 0 && owners_[index].owner->has_derivative(owners_[index].index);
}

// A rule of few points does not see where in an element a lump ends: there all points have the element's mean,
// (mean of f^(1/4))^4, between the geometric and the arithmetic one, as the answers of lumps on a finer mesh are. With
// a negative weight an element whose points differ could be unstable, too.
void FemSolid::multiply_fields() {
  factors_ = stiffness_;
  if (fields_.empty()) return;
  factors_.resize(static_cast<std::size_t>(entity_count()) * points_.size(), 1.0);
  const auto factor_at = [this](int element, const std::array<double, 4>& barycentric, double power) {
    double logarithm = 0.0;
    for (const auto& field : fields_) logarithm += field->log_factor(rest_at(element, barycentric));
    return std::exp(power * logarithm);
  };
  constexpr std::size_t kFew = 5;
  const bool by_mean = points_.size() > 1 && points_.size() <= kFew;
  const TetQuadrature rule = tet_quadrature(5);
  for (int e = 0; e < entity_count(); ++e) {
    double root = 0.0;
    for (int k = 0; k < rule.count() && by_mean; ++k) root += rule.weights[k] * factor_at(e, rule.points[k], 0.25);
    double* out = factors_.data() + static_cast<std::size_t>(e) * points_.size();
    for (std::size_t q = 0; q < points_.size(); ++q)
      out[q] *= by_mean ? std::pow(root, 4.0) : factor_at(e, quadrature_.points[q], 1.0);
  }
}

void FemSolid::set_stiffness(std::vector<double> factors) {
  if (!factors.empty() && factors.size() != static_cast<std::size_t>(entity_count()) * points_.size())
    throw ModelError("a stiffness field has " + std::to_string(factors.size()) + " factors, not one for each of " +
                     std::to_string(points_.size()) + " points of " + std::to_string(entity_count()) + " elements");
  stiffness_ = std::move(factors);
  multiply_fields();
}

Vec3 FemSolid::rest_of_point(int element, int point) const { return rest_at(element, quadrature_.points[point]); }

Vec3 FemSolid::rest_at(int element, const std::array<double, 4>& barycentric) const {
  Vec3 place = Vec3::Zero();
  for (int a = 0; a < 4; ++a)
    place += barycentric[a] * mesh_->rest.row(mesh_->nodes_of_element(element)[a]).transpose();
  return place;
}

double FemSolid::scale(int block, int point, int lane) const {
  const double plain = blocks_[block].volume[lane] * points_[point].weight;
  const int element = block * kPointLanes + lane;
  if (factors_.empty() || element >= entity_count()) return plain;
  return plain * factors_[static_cast<std::size_t>(element) * points_.size() + point];
}

// History: law by law, block by block, point by point.
std::size_t FemSolid::history_offset(std::size_t law, int block, int point) const {
  std::size_t offset = 0;
  for (std::size_t k = 0; k < law; ++k) offset += laws_[k]->history_per_point() * blocks_.size() * points_.size();
  offset += laws_[law]->history_per_point() * (block * points_.size() + point);
  return offset * kPointLanes;
}

std::size_t FemSolid::history_size() const {
  std::size_t size = 0;
  for (const auto& law : laws_) size += law->history_per_point() * blocks_.size() * points_.size() * kPointLanes;
  return size;
}

PointBatch FemSolid::batch_of(std::size_t law, int block, int point, const TermInput& input) const {
  const int index = block * static_cast<int>(points_.size()) + point;
  const bool remembers = laws_[law]->history_per_point() > 0;
  return {index, input.time_step, remembers ? input.history + history_offset(law, block, point) : nullptr};
}

void FemSolid::respond(int block, int point, const PointDeformation& deformation, const TermInput& input, bool tangent,
                       PointResponse& response) const {
  std::memset(&response, 0, tangent ? sizeof response : offsetof(PointResponse, tangent));
  for (std::size_t law = 0; law < laws_.size(); ++law)
    laws_[law]->add(batch_of(law, block, point, input), deformation, tangent, response);
  alignas(64) double factor[kPointLanes];
  for (int l = 0; l < kPointLanes; ++l) {
    factor[l] = scale(block, point, l);
    if (factor[l] == 0.0) response.energy[l] = 0.0;
    if (std::isfinite(response.energy[l])) response.energy[l] *= factor[l];
  }
  for (auto& stress : response.stress)
    for (int l = 0; l < kPointLanes; ++l) stress[l] *= factor[l];
  if (!tangent) return;
  for (auto& entry : response.tangent)
    for (int l = 0; l < kPointLanes; ++l) entry[l] *= factor[l];
}

void FemSolid::evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const {
  alignas(64) double corners[kRows * kPointLanes], residual[kRows * kPointLanes], tangent[kBlocks * kPointLanes];
  PointDeformation deformation;
  PointResponse response;
  const int rows = 3 * nodes_per_entity(), entries = 9 * pair_count(nodes_per_entity());
  for (int first = begin; first < end; first += kPointLanes) {
    const int index = first / kPointLanes, count = std::min(kPointLanes, end - first);
    const SolidBlock& block = blocks_[index];
    gather(block, nodes_per_entity(), input.x, corners);
    std::fill_n(residual, rows * kPointLanes, 0.0);
    if (output.tangent != nullptr) std::fill_n(tangent, entries * kPointLanes, 0.0);
    if (output.energy != nullptr) std::fill_n(output.energy + first, count, 0.0);
    for (int q = 0; q < points_per_element(); ++q) {
      solid_deformation(block, points_[q], corners, deformation);
      respond(index, q, deformation, input, output.tangent != nullptr, response);
      if (output.energy != nullptr)
        for (int l = 0; l < count; ++l) output.energy[first + l] += response.energy[l];
      solid_add_residual(block, points_[q], response.stress, residual);
      if (output.tangent != nullptr) solid_add_tangent(block, points_[q], response.tangent, tangent);
    }
    if (output.residual != nullptr)
      transpose(residual, rows, count, output.residual + static_cast<std::ptrdiff_t>(first) * rows);
    if (output.tangent != nullptr)
      transpose(tangent, entries, count, output.tangent + static_cast<std::ptrdiff_t>(first) * entries);
  }
}

template <typename Stress>
void FemSolid::integrate(int begin, int end, const double* x, const Stress& stress_at, double* out) const {
  alignas(64) double corners[kRows * kPointLanes], residual[kRows * kPointLanes], stress[9][kPointLanes];
  PointDeformation deformation;
  const int rows = 3 * nodes_per_entity();
  for (int first = begin; first < end; first += kPointLanes) {
    const int at = first / kPointLanes;
    gather(blocks_[at], nodes_per_entity(), x, corners);
    std::fill_n(residual, rows * kPointLanes, 0.0);
    for (int q = 0; q < points_per_element(); ++q) {
      solid_deformation(blocks_[at], points_[q], corners, deformation);
      stress_at(at, q, deformation, stress);
      solid_add_residual(blocks_[at], points_[q], stress, residual);
    }
    transpose(residual, rows, std::min(kPointLanes, end - first), out + static_cast<std::ptrdiff_t>(first) * rows);
  }
}

void FemSolid::differentiate(int index, int begin, int end, const TermInput& input, double* out) const {
  const Owner& chosen = owners_[index];
  const auto law = static_cast<std::size_t>(chosen.law);
  const auto stress_at = [&](int at, int q, const PointDeformation& deformation, double(*stress)[kPointLanes]) {
    laws_[law]->differentiate(chosen.index, batch_of(law, at, q, input), deformation, stress);
    for (int k = 0; k < 9; ++k)
      for (int l = 0; l < kPointLanes; ++l) stress[k][l] *= scale(at, q, l);
  };
  integrate(begin, end, input.x, stress_at, out);
}

void FemSolid::differentiate_stiffness(const std::vector<double>& field, int begin, int end, const TermInput& input,
                                       double* out) const {
  const auto stress_at = [&](int at, int q, const PointDeformation& deformation, double(*stress)[kPointLanes]) {
    PointResponse response;
    respond(at, q, deformation, input, false, response);
    for (int l = 0; l < kPointLanes; ++l) {
      const int element = std::min(at * kPointLanes + l, entity_count() - 1);
      const double weight = field[static_cast<std::size_t>(element) * points_.size() + q];
      for (int k = 0; k < 9; ++k) stress[k][l] = weight * response.stress[k][l];
    }
  };
  integrate(begin, end, input.x, stress_at, out);
}

void FemSolid::accept(const TermInput& input, double* history) const {
  if (history_size() == 0) return;
  alignas(64) double corners[kRows * kPointLanes];
  PointDeformation deformation;
  for (int at = 0; at < static_cast<int>(blocks_.size()); ++at) {
    gather(blocks_[at], nodes_per_entity(), input.x, corners);
    for (int q = 0; q < points_per_element(); ++q) {
      solid_deformation(blocks_[at], points_[q], corners, deformation);
      for (std::size_t law = 0; law < laws_.size(); ++law)
        if (laws_[law]->history_per_point() > 0)
          laws_[law]->accept(batch_of(law, at, q, input), deformation, history + history_offset(law, at, q));
    }
  }
}

}  // namespace tissued::core
