#include "core/diagnosis/words.hpp"

#include <map>

#include "core/effects/wording.hpp"

namespace tissued::core {

namespace {

constexpr double kDegrees = 57.29577951308232;

Vec3 vector_of(const Fit& fit, const std::string& name) {
  return {fit.value(name + ".x"), fit.value(name + ".y"), fit.value(name + ".z")};
}

std::string slip_summary(const Fit& fit, const Scene& scene) {
  std::string text;
  for (const SlippedMarker& slip : fit.hypothesis.slips) {
    const std::string& name = scene.markers[slip.marker].name;
    text += worded("%s moved by %.1f mm on the skin. ", name.c_str(), vector_of(fit, "marker-slip." + name).norm());
  }
  if (!text.empty()) text.pop_back();
  return text;
}

}  // namespace

std::string_view title_of(const std::string& kind) {
  if (kind == "latency") return "Markers arrive later than the pads' poses";
  if (kind == "registration") return "The tracker's frame does not lie where it is said to lie";
  if (kind == "marker-slip") return "Markers moved on the skin";
  if (kind == "unknown") return "Something is missing that this tool has no name for";
  const Effect* effect = find_effect(kind);
  return effect != nullptr ? effect->title() : std::string_view(kind);
}

std::string summary_of(const std::string& kind, const Fit& fit, const Scene& scene) {
  if (kind == "latency") {
    const double seconds = fit.value("latency.seconds");
    return worded("Markers arrive %.0f ms %s than the pads' poses.", 1e3 * std::abs(seconds),
                  seconds > 0.0 ? "later" : "earlier");
  }
  if (kind == "registration")
    return worded("The tracker's frame is turned by %.1f degrees and shifted by %.1f mm against the body's.",
                  kDegrees * vector_of(fit, "registration.rotation").norm(),
                  vector_of(fit, "registration.shift").norm());
  if (kind == "marker-slip") return slip_summary(fit, scene);
  if (kind == "parameters")
    return worded("Its Young's modulus is %.2f kPa rather than %.2f, its Poisson's ratio %.3f rather than %.3f.",
                  fit.value("youngs_modulus"), scene.material.youngs_modulus, fit.value("poissons_ratio"),
                  scene.material.poissons_ratio);
  const Effect* effect = find_effect(kind);
  return effect != nullptr ? effect->sentence(effect_values(*effect, fit, scene)) : std::string();
}

std::string_view experiment_for(const std::string& kind) {
  static const std::map<std::string, std::string_view, std::less<>> kExperiments{
      {"parameters", "push one pad slowly to two depths with its force measured"},
      {"viscoelasticity", "push quickly, hold for ten seconds, and release quickly"},
      {"strain-stiffening", "push one pad slowly to 5, 10, 15 and 20 mm with its force measured"},
      {"inclusion", "push from the side that is nearest to the suspected lump, and from the one across"},
      {"stiffness-gradient", "push from opposite sides by the same depth, with forces measured"},
      {"anisotropy", "push along two directions at right angles by the same depth, with forces measured"},
      {"skin", "push shallowly with a small pad, and deeply with a large one"},
      {"softening", "push twice in the same way, after a deep push and after a long rest"},
      {"swelling", "record at rest, without a push, for a minute"},
      {"gravity", "record at rest in two postures"},
      {"loose-base", "push sideways from four sides near the support"},
      {"sliding-actuator", "push at a slant, with markers close to the pad's edge"},
      {"latency", "push and release quickly several times"},
      {"registration", "record at rest with as many markers as can be seen"},
      {"marker-slip", "record at rest before and after the push"},
  };
  const auto found = kExperiments.find(kind);
  return found != kExperiments.end() ? found->second : "push from further sides, with forces measured";
}

}  // namespace tissued::core
