#include "core/simulator.hpp"

#include <array>

#include "core/admm_simulator.hpp"
#include "core/fem_simulator.hpp"
#include "core/pbd_simulator.hpp"
#include "core/rigid_simulator.hpp"

namespace tissued::core {

std::span<const std::string_view> simulator_names() {
  static constexpr std::array<std::string_view, 5> kNames{"kf-admm", "admm", "fem", "pbd", "rigid"};
  return kNames;
}

bool reads_markers(const SimulatorOptions& options) {
  return options.kind == "kf-admm" ||
         (options.kind == "rigid" && options.rigid.follow == RigidOptions::Follow::markers);
}

std::unique_ptr<Simulator> make_simulator(const Scene& scene, const SimulatorOptions& options) {
  if (options.kind == "kf-admm") return std::make_unique<AdmmSimulator>(scene, options, true);
  if (options.kind == "admm") return std::make_unique<AdmmSimulator>(scene, options, false);
  if (options.kind == "fem") return std::make_unique<FemSimulator>(scene, options);
  if ((options.kind == "pbd" || options.kind == "rigid") && !options.effects.empty())
    throw ModelError("the simulator " + options.kind + " has no effects: " + std::to_string(options.effects.size()) +
                     " were asked for");
  if (options.kind == "pbd") return std::make_unique<PbdSimulator>(scene, options);
  if (options.kind == "rigid") return std::make_unique<RigidSimulator>(scene, options);
  throw ModelError("simulator.kind \"" + options.kind + "\" is not known: kf-admm, admm, fem, pbd or rigid");
}

}  // namespace tissued::core
