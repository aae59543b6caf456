#include "core/effects/effect_numbers.hpp"

namespace tissued::core {

std::vector<BodyNumber> moduli_of(const Scene& scene) {
  return {{{"youngs_modulus", "kPa", 1e-3, 1e6}, scene.material.youngs_modulus},
          {{"poissons_ratio", "1", 0.0, 0.4999}, scene.material.poissons_ratio}};
}

std::vector<BodyNumber> gravity_of(const Scene& scene) {
  return {{{"gravity_x", "g0"}, scene.gravity.x()},
          {{"gravity_y", "g0"}, scene.gravity.y()},
          {{"gravity_z", "g0"}, scene.gravity.z()}};
}

}  // namespace tissued::core
