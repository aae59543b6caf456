#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/image_plane.hpp"
#include "core/scene.hpp"

namespace tissued::daemon {

/// What a scripted probe does one after the other.
enum class ProbeMove {
  press,  ///< from above the skin to its depth
  slide,  ///< over the body to the other side of its top, as deep as it is
  hold,   ///< stays
  lift,   ///< to above the skin
};

struct ScriptedProbe {
  std::string name;  ///< of the tracked object, in the scene
  std::vector<ProbeMove> moves;
};

/// `NAME=press,slide,lift`. Throws std::runtime_error that names what is wrong.
ScriptedProbe parse_probe_script(const std::string& text);

/// Where a probe goes over the top of a body: its face is turned to the body, along y of its image where that is known
/// (down the rows), else along -z of the tracked object. The script begins after a second above the skin and is
/// repeated; positions and velocities are continuous.
class ProbeScript {
 public:
  static constexpr double kAbove = 5.0;      ///< mm, between the lifted face and the skin at rest
  static constexpr double kFurthest = 0.35;  ///< rad, of the face's normal from vertical, at either end of a slide

  /// depth: mm, of the face below the skin at rest. seconds: of one move. Scene: read here only.
  ProbeScript(const core::Scene& scene, const core::ProbeShape& shape, const std::optional<core::ImagePlane>& image,
              std::vector<ProbeMove> moves, double depth, double seconds);

  /// tissue_T_probe, `time` s after the beginning.
  core::RigidTransform at(double time) const;

 private:
  // How far from its face's place at -kFurthest to that at kFurthest, and from above to its depth: 0 to 1.
  struct Share {
    double along = 0.0, down = 0.0;
  };
  Share after(std::size_t moves) const;
  Share share_at(double time) const;

  std::vector<core::Vec3> skin_;  // mm, at rest
  core::Mat3 face_;               // columns in the probe's frame: sideways, across, out of the face's back
  core::Vec3 face_center_;        // mm, probe
  std::vector<ProbeMove> moves_;
  double depth_, seconds_;
};

}  // namespace tissued::daemon
