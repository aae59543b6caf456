#include "core/simulator.hpp"

#include <array>

#include "core/admm_simulator.hpp"
#include "core/fem_simulator.hpp"

namespace tissued::core {

std::span<const std::string_view> simulator_names() {
  static constexpr std::array<std::string_view, 3> kNames{"kf-admm", "admm", "fem"};
  return kNames;
}

std::unique_ptr<Simulator> make_simulator(const Scene& scene, const SimulatorOptions& options) {
  if (options.kind == "kf-admm") return std::make_unique<AdmmSimulator>(scene, options, true);
  if (options.kind == "admm") return std::make_unique<AdmmSimulator>(scene, options, false);
  if (options.kind == "fem") return std::make_unique<FemSimulator>(scene, options);
  throw ModelError("simulator.kind \"" + options.kind + "\" is not known: kf-admm, admm or fem");
}

}  // namespace tissued::core
