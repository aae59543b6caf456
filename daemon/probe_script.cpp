#include "daemon/probe_script.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <sstream>
#include <stdexcept>

#include "daemon/pad_motion.hpp"

namespace tissued::daemon {
namespace {

constexpr double kRestBefore = 1.0;  // s
constexpr std::array<std::string_view, 4> kNames{"press", "slide", "hold", "lift"};

}  // namespace

ScriptedProbe parse_probe_script(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos)
    throw std::runtime_error("--probe " + text + ": should be NAME=press,slide,hold,lift");
  ScriptedProbe probe{text.substr(0, equals), {}};
  std::istringstream stream(text.substr(equals + 1));
  for (std::string word; std::getline(stream, word, ',');) {
    const auto found = std::find(kNames.begin(), kNames.end(), word);
    if (found == kNames.end())
      throw std::runtime_error("--probe " + text + ": `" + word + "` is not press, slide, hold or lift");
    probe.moves.push_back(static_cast<ProbeMove>(found - kNames.begin()));
  }
  if (probe.moves.empty()) throw std::runtime_error("--probe " + text + ": no move");
  return probe;
}

ProbeScript::ProbeScript(const core::Scene& scene, const core::ProbeShape& shape,
                         const std::optional<core::ImagePlane>& image, std::vector<ProbeMove> moves, double depth,
                         double seconds)
    : moves_(std::move(moves)), depth_(depth), seconds_(seconds) {
  for (int node : core::nodes_of(*scene.mesh.find_surface(scene.skin_surface))) skin_.push_back(scene.mesh.node(node));
  const core::Vec3 back = image ? core::Vec3(-image->probe_T_image.rotation.col(1)) : core::Vec3::UnitZ();
  const core::Vec3 side = image ? core::Vec3(image->probe_T_image.rotation.col(0)) : core::Vec3::UnitX();
  face_.col(0) = side;
  face_.col(1) = back.cross(side);
  face_.col(2) = back;
  face_center_ = shape.center - back.cwiseAbs().dot(shape.half_extents) * back;
}

ProbeScript::Share ProbeScript::after(std::size_t moves) const {
  // Sliding to and fro: after an odd number of slides the probe is at the far end.
  const auto count = [this](ProbeMove move, std::size_t first) {
    return std::count(moves_.begin(), moves_.begin() + static_cast<std::ptrdiff_t>(first), move);
  };
  const std::size_t whole = moves / moves_.size(), rest = moves % moves_.size();
  const auto slides =
      static_cast<std::ptrdiff_t>(whole) * count(ProbeMove::slide, moves_.size()) + count(ProbeMove::slide, rest);
  Share share;
  share.along = slides % 2 == 0 ? 0.0 : 1.0;
  for (std::size_t k = 0; k < std::min(moves, 2 * moves_.size()); ++k) {
    const ProbeMove move = moves_[(moves - 1 - k) % moves_.size()];
    if (move != ProbeMove::press && move != ProbeMove::lift) continue;
    share.down = move == ProbeMove::press ? 1.0 : 0.0;
    break;
  }
  return share;
}

ProbeScript::Share ProbeScript::share_at(double time) const {
  const double moves = std::max(0.0, time - kRestBefore) / seconds_;
  const auto done = static_cast<std::size_t>(moves);
  const Share from = after(done), to = after(done + 1);
  const double s = minimum_jerk(moves - static_cast<double>(done));
  return {from.along + s * (to.along - from.along), from.down + s * (to.down - from.down)};
}

core::RigidTransform ProbeScript::at(double time) const {
  const Share share = share_at(time);
  const double angle = (2.0 * share.along - 1.0) * kFurthest;
  const core::Mat3 tilt = Eigen::AngleAxisd(angle, core::Vec3::UnitY()).toRotationMatrix();
  const core::Vec3 outwards = tilt * core::Vec3::UnitZ();
  const core::Vec3* top = &skin_.front();
  for (const core::Vec3& p : skin_)
    if (p.dot(outwards) > top->dot(outwards)) top = &p;
  // Level with the outermost node, but on the vertical plane of the tilt: nodes are no place to jump between.
  const core::Vec3 place = top->dot(outwards) * outwards;
  core::RigidTransform pose;
  pose.rotation = tilt * face_.transpose();
  const double height = kAbove - share.down * (kAbove + depth_);
  pose.translation = place + height * outwards - pose.rotation * face_center_;
  return pose;
}

}  // namespace tissued::daemon
