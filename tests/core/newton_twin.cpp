#include "tests/core/newton_twin.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/neo_hookean.hpp"

namespace tissued::core::testing {

namespace {

using Corners = Eigen::Matrix<double, 3, 4>;
using Mat12 = Eigen::Matrix<double, 12, 12>;
using Vec12 = Eigen::Matrix<double, 12, 1>;

struct Element {
  Eigen::Matrix<double, 4, 3> gradients;  // of the shape functions, 1/mm
  double volume;                          // mm3
};

Element element_of(const TetMesh& mesh, const Tet& tet) {
  Eigen::Matrix4d affine;
  for (int a = 0; a < 4; ++a) affine.col(a) << 1.0, mesh.node(tet[a]);
  return {affine.inverse().rightCols<3>(), std::abs(affine.determinant()) / 6.0};
}

Corners corners_of(const NodeField& x, const Tet& tet) {
  Corners corners;
  for (int a = 0; a < 4; ++a) corners.col(a) = x.row(tet[a]).head<3>().transpose();
  return corners;
}

// Derivative of the element's energy by its corners, mN.
Corners element_gradient(const Material& material, const Element& element, const Corners& corners) {
  return element.volume * first_piola(material, corners * element.gradients) * element.gradients.transpose();
}

Mat12 element_hessian(const Material& material, const Element& element, const Corners& corners) {
  constexpr double kStep = 1e-5;  // mm
  Mat12 hessian;
  for (int i = 0; i < 12; ++i) {
    Corners plus = corners, minus = corners;
    plus.data()[i] += kStep;
    minus.data()[i] -= kStep;
    const Corners column =
        (element_gradient(material, element, plus) - element_gradient(material, element, minus)) / (2.0 * kStep);
    hessian.col(i) = Eigen::Map<const Vec12>(column.data());
  }
  return hessian;
}

class Twin {
 public:
  Twin(const Scene& scene, const NodeField& external)
      : scene_(scene), external_(external), is_held_(static_cast<std::size_t>(scene.mesh.node_count()), 0) {
    for (const Tet& tet : scene.mesh.tets) elements_.push_back(element_of(scene.mesh, tet));
  }

  void hold(int node) { is_held_[node] = 1; }

  // kPa mm3 = mJ / 1000; infinite where an element is inverted.
  double energy(const NodeField& x) const {
    double sum = -(external_.cwiseProduct(x)).sum();
    for (std::size_t e = 0; e < elements_.size(); ++e)
      sum += elements_[e].volume *
             strain_energy_density(scene_.material, corners_of(x, scene_.mesh.tets[e]) * elements_[e].gradients);
    return sum;
  }

  // (3n) mN: derivative of the energy.
  Eigen::VectorXd gradient(const NodeField& x) const {
    Eigen::VectorXd g(3 * x.rows());
    for (Eigen::Index i = 0; i < x.rows(); ++i) g.segment<3>(3 * i) = -external_.row(i).head<3>().transpose();
    for (std::size_t e = 0; e < elements_.size(); ++e) {
      const Tet& tet = scene_.mesh.tets[e];
      const Corners corners = element_gradient(scene_.material, elements_[e], corners_of(x, tet));
      for (int a = 0; a < 4; ++a) g.segment<3>(3 * tet[a]) += corners.col(a);
    }
    return g;
  }

  // Newton on the free nodes until nothing moves.
  void equilibrate(NodeField& x) const {
    std::vector<int> open;
    for (int i = 0; i < x.rows(); ++i)
      for (int axis = 0; axis < 3; ++axis)
        if (!is_held_[i]) open.push_back(3 * i + axis);
    for (int iteration = 0; iteration < 60; ++iteration) {
      const Eigen::VectorXd right = gradient(x)(open);
      const Eigen::MatrixXd h = hessian(x)(open, open);
      const Eigen::VectorXd move = h.ldlt().solve(-right);
      const double before = energy(x);
      double step = 1.0;
      NodeField trial = x;
      for (; step > 1e-6; step *= 0.5) {
        trial = x;
        for (std::size_t i = 0; i < open.size(); ++i)
          trial(open[i] / 3, open[i] % 3) += step * move[static_cast<Eigen::Index>(i)];
        if (energy(trial) <= before + 1e-12 * std::abs(before) + 1e-12) break;
      }
      x = trial;
      if (move.cwiseAbs().maxCoeff() < 1e-11) return;
    }
  }

  const std::vector<std::uint8_t>& is_held() const { return is_held_; }

 private:
  Eigen::MatrixXd hessian(const NodeField& x) const {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(3 * x.rows(), 3 * x.rows());
    for (std::size_t e = 0; e < elements_.size(); ++e) {
      const Tet& tet = scene_.mesh.tets[e];
      const Mat12 local = element_hessian(scene_.material, elements_[e], corners_of(x, tet));
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) h.block<3, 3>(3 * tet[a], 3 * tet[b]) += local.block<3, 3>(3 * a, 3 * b);
    }
    return 0.5 * (h + h.transpose());
  }

  const Scene& scene_;
  const NodeField& external_;
  std::vector<Element> elements_;
  std::vector<std::uint8_t> is_held_;
};

}  // namespace

TwinAnswer solve_by_newton(const Scene& scene, const std::vector<PadInput>& pads, const NodeField& external,
                           int loads) {
  TwinAnswer answer;
  answer.positions = NodeField::Zero(scene.mesh.node_count(), 4);
  answer.positions.leftCols<3>() = scene.mesh.rest;
  NodeField scaled = external;
  Twin twin(scene, scaled);
  for (int node : nodes_of(*scene.mesh.find_surface(scene.fixed_surface))) twin.hold(node);
  for (int load = 1; load <= loads; ++load) {
    const double share = static_cast<double>(load) / loads;
    scaled = share * external;
    for (std::size_t p = 0; p < pads.size(); ++p) {
      if (pads[p].kind != PadInput::Kind::pose) continue;
      const Pad& pad = scene.pads[p];
      const Eigen::AngleAxisd turn(pads[p].rotation);
      const Mat3 part = Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix();
      const Vec3 center = pad.center + share * (pads[p].center - pad.center);
      for (int node : nodes_of(*scene.mesh.find_surface(pad.surface))) {
        twin.hold(node);
        answer.positions.row(node).head<3>() = (center + part * (scene.mesh.node(node) - pad.center)).transpose();
      }
    }
    twin.equilibrate(answer.positions);
  }
  const Eigen::VectorXd gradient = twin.gradient(answer.positions);
  for (int i = 0; i < scene.mesh.node_count(); ++i) {
    const Vec3 force = gradient.segment<3>(3 * i) / kMillinewtonPerNewton;
    answer.reactions.push_back(twin.is_held()[i] ? force : Vec3(Vec3::Zero()));
    if (!twin.is_held()[i]) answer.unbalanced = std::max(answer.unbalanced, force.norm());
  }
  return answer;
}

NodeField external_forces(const Scene& scene, const std::vector<PadInput>& pads) {
  NodeField external = NodeField::Zero(scene.mesh.node_count(), 4);
  const double density = scene.material.density * kKilogramPerDensityVolume;
  for (const Tet& tet : scene.mesh.tets)
    for (int node : tet)
      external.row(node).head<3>() +=
          0.25 * signed_volume(scene.mesh, tet) * density * kStandardGravity * scene.gravity.transpose();
  for (std::size_t p = 0; p < pads.size(); ++p) {
    if (pads[p].kind != PadInput::Kind::force) continue;
    double total = 0.0;
    NodeField share = NodeField::Zero(external.rows(), 4);
    for (const Triangle& t : scene.mesh.find_surface(scene.pads[p].surface)->triangles) {
      const Vec3 a = scene.mesh.node(t[0]), b = scene.mesh.node(t[1]), c = scene.mesh.node(t[2]);
      const double area = 0.5 * (b - a).cross(c - a).norm();
      total += area;
      for (int node : t) share.row(node).head<3>() += area / 3.0 * kMillinewtonPerNewton * pads[p].force.transpose();
    }
    external += share / total;
  }
  return external;
}

}  // namespace tissued::core::testing
