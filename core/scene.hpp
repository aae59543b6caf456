// What a simulation is told: the body, what holds it, what pushes it, what is seen of it and what is asked about it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/mesh.hpp"
#include "core/probe.hpp"
#include "core/types.hpp"

namespace tissued::core {

// Neo-Hookean, equation (11) with J = det F.
struct Material {
  double youngs_modulus = 6.0;  // kPa
  double poissons_ratio = 0.45;
  double density = 1.0;  // g/cm3

  double shear_modulus() const { return youngs_modulus / (2.0 * (1.0 + poissons_ratio)); }       // kPa
  double bulk_modulus() const { return youngs_modulus / (3.0 * (1.0 - 2.0 * poissons_ratio)); }  // kPa
};

// An actuator: a rigid plate glued to the nodes of the facets of a surface group.
struct Pad {
  std::string name;
  std::string surface;  // group of the mesh
  Vec3 center;          // mm, tissue, at rest; the pose that a tracker reports when the pad does not push
  Vec3 direction;       // unit push direction
};

struct Marker {
  std::string name;
  Vec3 rest;  // mm, tissue; on the skin, placed to about half a millimetre
};

struct Target {
  std::string name;
  Vec3 rest;  // mm, tissue; inside, exact
};

// A dead load along a straight edge of the body, such as a weight that lies on it.
struct EdgeLoad {
  std::array<Vec3, 2> edge;  // mm, tissue, at rest: its ends
  Vec3 force;                // N, on the tissue
  double mass = 0.0;         // g, that moves with it; its weight is among `force`
};

struct Scene {
  std::string name;
  TetMesh mesh;
  Material material;
  std::string fixed_surface = "base";  // group of the mesh held still
  std::string skin_surface = "skin";
  Vec3 gravity = Vec3::Zero();  // multiples of g0
  std::vector<Pad> pads;
  std::vector<Probe> probes;
  std::vector<Marker> markers;
  std::vector<Target> targets;
  double marker_noise = 0.1;  // mm, standard deviation per axis
  double rate = 100.0;        // Hz, nominal frame rate of the tracker
};

}  // namespace tissued::core
