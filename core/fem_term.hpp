// The seam for physics: the energy of a finite element body is a sum of terms, and a term is a sum over its entities
// (elements, facets, single nodes) of something that depends on the entity's nodes alone. A term that has no potential
// (a viscous stress) gives residual and tangent, and an energy of zero.
//
// A new effect inside the volume is a FemLaw (core/fem_law.hpp), whose stresses are summed at each quadrature point
// before they are integrated; anything else (a membrane on the skin, a mass, a spring, a sliding contact) is a FemTerm.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/pad_input.hpp"

namespace tissued::core {

// A number of a term or law that can be set between solves, and by which answers can be differentiated.
struct FemParameter {
  std::string name;  // as in the contract of diagnose, e.g. youngs_modulus
  std::string unit;
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
};

// Whatever has such numbers.
class FemAdjustable {
 public:
  virtual ~FemAdjustable() = default;
  virtual std::span<const FemParameter> parameters() const { return {}; }
  virtual double parameter(int) const { return 0.0; }
  virtual void set_parameter(int, double) {}
  // False where there is no derivative in closed form, only by differences.
  virtual bool has_derivative(int) const { return false; }
};

// Where a term is evaluated.
struct TermInput {
  const double* x = nullptr;        // (3n) mm, positions of all nodes
  double time_step = 0.0;           // s since the accepted state that `history` belongs to; 0: no time passes
  const double* history = nullptr;  // (history_size of the term)
  std::span<const PadInput> pads;   // of the scene; empty: none touches. For terms that stand in for a hold
};

// Slices for entities [begin, end), which begin at entity 0; what is not asked for is null.
struct TermOutput {
  double* energy = nullptr;    // (entities) kPa mm3; infinite where the entity is inverted
  double* residual = nullptr;  // (entities x nodes x 3) mN, derivative of the energy by the entity's nodes
  double* tangent = nullptr;   // (entities x pairs x 9) mN/mm, blocks (a, b), b <= a, in the order of pair_index
};

constexpr int pair_index(int a, int b) { return a * (a + 1) / 2 + b; }
constexpr int pair_count(int nodes) { return nodes * (nodes + 1) / 2; }

// What one entity writes to, set to zero; null where it is not asked for.
struct EntityOutput {
  double *residual = nullptr, *tangent = nullptr;
};
inline EntityOutput cleared(const TermOutput& output, int entity, int nodes) {
  const std::ptrdiff_t rows = 3 * nodes, entries = 9 * pair_count(nodes);
  EntityOutput out;
  if (output.energy != nullptr) output.energy[entity] = 0.0;
  if (output.residual != nullptr) out.residual = std::fill_n(output.residual + entity * rows, rows, 0.0) - rows;
  if (output.tangent != nullptr) out.tangent = std::fill_n(output.tangent + entity * entries, entries, 0.0) - entries;
  return out;
}

class FemTerm : public FemAdjustable {
 public:
  virtual std::string_view name() const = 0;
  virtual int entity_count() const = 0;
  virtual int nodes_per_entity() const = 0;
  virtual std::span<const int> nodes_of_entity(int entity) const = 0;
  virtual bool has_tangent() const { return true; }
  // Entities are evaluated in ranges that begin at multiples of this.
  virtual int batch() const { return 1; }

  // Overwrites what is asked for of entities [begin, end). Called from several threads at once, for different ranges.
  virtual void evaluate(int begin, int end, const TermInput& input, const TermOutput& output) const = 0;

  // Overwrites `residual` (as in TermOutput) of entities [begin, end) with its derivative by parameter `index`.
  virtual void differentiate(int, int, int, const TermInput&, double*) const {}

  // Doubles that the term keeps from one accepted state to the next; zero at rest.
  virtual std::size_t history_size() const { return 0; }
  // The state of `input` is accepted: writes the history that follows on input.history.
  virtual void accept(const TermInput&, double*) const {}

  // Of a term that presses pads on the tissue (they do not hold their nodes then): adds the force of each pad, N.
  virtual void add_pad_forces(const TermInput&, std::span<Vec3>) const {}
  // Adds the derivative of one pad's force along an axis by all positions, (3n) N/mm.
  virtual void add_pad_slope(int, const Vec3&, const TermInput&, Eigen::VectorXd&) const {}
};

}  // namespace tissued::core
