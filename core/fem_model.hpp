// A finite element body: nodes, elements, terms, and the places that are asked about. Its structure does not change;
// the numbers of its terms may be set between solves.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/fem_inertia.hpp"
#include "core/fem_mesh.hpp"
#include "core/fem_pattern.hpp"
#include "core/fem_solid.hpp"
#include "core/fem_time_scheme.hpp"
#include "core/scene.hpp"

namespace tissued::core {

// What a body is made of before it is put together.
struct FemPhysics {
  std::vector<std::unique_ptr<FemLaw>> laws;          // summed at the quadrature points; neo-Hookean to begin with
  std::vector<std::unique_ptr<FemTerm>> terms;        // of the energy, beside the solid; gravity to begin with
  std::vector<std::unique_ptr<FemTerm>> masses;       // of the kinetic form (see FemInertia)
  std::vector<std::unique_ptr<FemField>> fields;      // of stiffness, multiplied; none to begin with
  std::vector<std::unique_ptr<FemDamping>> dampings;  // added up; none to begin with
  std::vector<int> fixed_nodes;                       // ascending; the nodes of the fixed surface to begin with
  bool pads_hold = true;                              // pads hold their nodes; false: a term presses them on
  std::map<std::string, std::string> other_names;     // of parameters: name, and what the laws and terms call it
};

// How a physical effect enters: it changes the physics of a body. Scene and mesh outlive the body.
using FemEffect = std::function<void(const Scene&, const FemMesh&, FemPhysics&)>;

struct FemOptions {
  FemElement element = FemElement::p2;
  // See tet_quadrature. 0: 1 for P1, which is exact; for P2 3, as the reference answers have, and 2 where a law
  // remembers: points of an element then differ in stiffness, and with the negative weight of 3 it would be unstable.
  int quadrature_degree = 0;
  MassMatrix mass = MassMatrix::consistent;
  std::vector<FemEffect> effects;
};

class FemModel {
 public:
  // Throws ModelError: group missing, target outside the body, numbers out of range.
  FemModel(const Scene& scene, const FemOptions& options);
  FemModel(const FemModel&) = delete;
  FemModel& operator=(const FemModel&) = delete;

  const Scene& scene() const { return scene_; }
  const FemMesh& mesh() const { return mesh_; }
  const FemPattern& pattern() const { return pattern_; }

  // Of the energy; the solid first.
  const std::vector<std::unique_ptr<FemTerm>>& terms() const { return terms_; }
  const std::vector<std::unique_ptr<FemTerm>>& masses() const { return masses_; }
  FemSolid& solid() { return *solid_; }
  const FemSolid& solid() const { return *solid_; }

  // Sets a parameter of that name in everything that has it (density is one of gravity and of inertia). Throws
  // ModelError where nothing has it or the value is out of its bounds.
  void set_parameter(const std::string& name, double value);
  // Throws ModelError where nothing has it.
  double parameter(const std::string& name) const;
  // What terms call a parameter that FemPhysics::other_names may have given another name.
  const std::string& own_name(const std::string& name) const;

  RayleighDamping damping() const;  // that the body has of itself
  // Counts calls of set_parameter: whatever is kept of the model's numbers is stale when it has changed.
  std::uint64_t revision() const { return revision_; }
  bool pads_hold() const { return pads_hold_; }
  const std::vector<std::uint8_t>& fixed() const { return fixed_; }                   // (n) nonzero: never moves
  const std::vector<std::vector<int>>& pad_nodes() const { return pad_nodes_; }       // (pads), ascending
  const std::vector<std::vector<double>>& pad_shares() const { return pad_shares_; }  // of a pad's force
  const std::vector<FemPoint>& marker_points() const { return marker_points_; }
  const std::vector<FemPoint>& target_points() const { return target_points_; }
  Eigen::VectorXd rest() const;  // (3n) mm

 private:
  Scene scene_;
  FemMesh mesh_;
  FemSolid* solid_;
  std::vector<std::unique_ptr<FemTerm>> terms_, masses_;
  std::vector<std::unique_ptr<FemDamping>> dampings_;
  std::map<std::string, std::string> other_names_;
  std::vector<FemAdjustable*> adjustables_;  // all that have parameters
  std::uint64_t revision_ = 0;
  bool pads_hold_;
  FemPattern pattern_;
  std::vector<std::uint8_t> fixed_;
  std::vector<std::vector<int>> pad_nodes_;
  std::vector<std::vector<double>> pad_shares_;
  std::vector<FemPoint> marker_points_, target_points_;
};

}  // namespace tissued::core
