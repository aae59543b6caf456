#include "daemon/image_overlay.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "daemon/canvas.hpp"
#include "daemon/confidence.hpp"

namespace tissued::daemon {
namespace {

using Eigen::Vector2d;
using protocol::Validity;

constexpr double kCircle = 3.0;        // mm, radius around a target
constexpr double kInPlane = 2.0;       // mm
constexpr double kFaded = 25.0;        // mm from the plane, where a target is as pale as it gets
constexpr double kHolds95 = 2.4477;    // standard deviations of two dimensions: sqrt(5.991)
constexpr double kWithin95 = 1.95996;  // standard deviations of one
constexpr Rgb kValid{80, 240, 140}, kFar{150, 190, 230}, kDegraded{255, 190, 60}, kInvalid{255, 80, 70};

Rgb colour_of(const protocol::ImageTarget& target, Validity validity) {
  if (validity == Validity::invalid || validity == Validity::no_data) return kInvalid;
  if (validity == Validity::degraded) return kDegraded;
  return is_in_plane(target) ? kValid : kFar;
}

double text_height(const RgbImage& image) { return std::clamp(image.height / 38.0, 9.0, 28.0); }

std::string label_of(const std::string& name, double distance) {
  char text[64];
  std::snprintf(text, sizeof text, "%s %+.1f mm", name.c_str(), distance);
  return text;
}

// Puts labels beside what they name, inside of the image and not on one another.
class Labels {
 public:
  Labels(Canvas& canvas, const RgbImage& image) : canvas_(&canvas), size_(image.width, image.height) {}

  void draw(const Vector2d& beside, double gap, double height, const std::string& text, const Stroke& stroke) {
    const Vector2d extent(Canvas::text_width(height, text), 1.5 * height);
    Vector2d place = beside + Vector2d(gap, -0.5 * height);
    if (place.x() + extent.x() > size_.x() - 2.0) place.x() = beside.x() - gap - extent.x();
    place.x() = std::clamp(place.x(), 2.0, std::max(2.0, size_.x() - extent.x() - 2.0));
    place.y() = std::clamp(place.y(), 2.0, std::max(2.0, size_.y() - extent.y()));
    // Down, and from the bottom to the top again, until there is room; at last wherever it is.
    const int tries = static_cast<int>(size_.y() / extent.y());
    for (int k = 0; k < tries && is_taken(place, extent); ++k) {
      place.y() += extent.y();
      if (place.y() + extent.y() > size_.y()) place.y() = 2.0;
    }
    taken_.push_back({place, extent});
    canvas_->draw_text(place, height, text, stroke);
  }
  void keep_free(const Vector2d& corner, const Vector2d& extent) { taken_.push_back({corner, extent}); }

 private:
  struct Box {
    Vector2d corner, extent;
  };
  bool is_taken(const Vector2d& corner, const Vector2d& extent) const {
    return std::any_of(taken_.begin(), taken_.end(), [&](const Box& box) {
      return ((box.corner - corner).array() < extent.array()).all() &&
             ((corner - box.corner).array() < box.extent.array()).all();
    });
  }

  Canvas* canvas_;
  Vector2d size_;
  std::vector<Box> taken_;
};

// A target beside the image: an arrow at the border.
void draw_way_out(Canvas& canvas, Labels& labels, const RgbImage& image, const Vector2d& at, const std::string& label,
                  const Stroke& stroke) {
  const double margin = 1.5 * text_height(image);
  const Vector2d tip(std::clamp(at.x(), margin, image.width - 1 - margin),
                     std::clamp(at.y(), margin, image.height - 1 - margin));
  const Vector2d way = (at - tip).normalized(), across(-way.y(), way.x());
  const Vector2d head = tip + 0.8 * margin * way;
  canvas.draw_line(tip, head, stroke);
  for (const double side : {-1.0, 1.0}) canvas.draw_line(head, head - 0.4 * margin * (way + side * across), stroke);
  labels.draw(tip, margin, text_height(image), label, stroke);
}

void draw_target(Canvas& canvas, Labels& labels, const RgbImage& image, const protocol::ProbeView& frame,
                 const protocol::ImageTarget& target, const std::string& name) {
  const bool near = is_in_plane(target);
  Stroke stroke;
  stroke.colour = colour_of(target, frame.validity);
  stroke.width = std::clamp(image.height / 280.0, 1.4, 4.0);
  stroke.opacity = near ? 1.0 : std::clamp(1.0 - std::abs(target.distance) / kFaded, 0.5, 0.9);
  stroke.dash = near ? 0.0 : 4.0 * stroke.width;
  const Vector2d at(target.pixel[0], target.pixel[1]);
  const std::string label = label_of(name, target.distance);
  if (!target.inside) {
    Stroke whole = stroke;
    whole.dash = 0.0;
    return draw_way_out(canvas, labels, image, at, label, whole);
  }
  const Vector2d circle(kCircle / frame.spacing[0], kCircle / frame.spacing[1]);
  canvas.draw_ellipse(at, circle, 0.0, stroke);
  Stroke thin = stroke;
  thin.width = 0.7 * stroke.width;
  thin.opacity = 0.8 * stroke.opacity;
  canvas.draw_ellipse(at, kHolds95 * Vector2d(target.axes[0], target.axes[1]), target.angle, thin);
  canvas.fill_disc(at, 1.5 * stroke.width, stroke);
  labels.draw(at, circle.x() + 3.0 * stroke.width, text_height(image), label, stroke);
}

// What is wrong with all of it.
void draw_banner(Canvas& canvas, Labels& labels, const RgbImage& image, const protocol::ProbeView& frame) {
  std::string words;
  Stroke stroke;
  if (frame.validity != Validity::valid) {
    words = std::string(protocol::to_string(frame.validity));
    for (const std::string& reason : reason_names(frame.reasons)) words += ", " + reason;
    stroke.colour = frame.validity == Validity::degraded ? kDegraded : kInvalid;
    char age[40];
    std::snprintf(age, sizeof age, ", %.0f ms old", static_cast<double>(frame.age_ns) * 1e-6);
    words += age;
  }
  if (!frame.seen) {
    words += words.empty() ? "probe not seen" : ", probe not seen";
    stroke.colour = kInvalid;
  }
  if (words.empty()) return;
  const double usual = text_height(image), margin = 0.7 * usual;
  const double height = usual * std::min(1.0, (image.width - 2.0 * margin) / Canvas::text_width(usual, words));
  const Vector2d extent(image.width - 1.0, 2.4 * usual);
  canvas.fill_box({0.0, 0.0}, extent, {{0, 0, 0}, 1.0, 0.55, 0.0});
  canvas.draw_text({margin, 0.5 * (extent.y() - height)}, height, words, stroke);
  labels.keep_free({0.0, 0.0}, extent);
}

}  // namespace

bool is_in_plane(const protocol::ImageTarget& target) {
  return std::abs(target.distance) <= std::max(kInPlane, kWithin95 * target.distance_sd);
}

void draw_overlay(const JoinedView& view, const std::vector<std::string>& names, RgbImage& image) {
  const protocol::ProbeView& frame = view.frame;
  if (!frame.has_image || frame.size[0] != image.width || frame.size[1] != image.height)
    throw std::runtime_error("the image has " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                             " pixels, the probe's calibration " + std::to_string(frame.size[0]) + " x " +
                             std::to_string(frame.size[1]));
  Canvas canvas(image);
  Labels labels(canvas, image);
  draw_banner(canvas, labels, image, frame);
  // The nearest first, whose labels then are where they belong.
  std::vector<protocol::ImageTarget> targets = view.targets;
  std::stable_sort(targets.begin(), targets.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.distance) < std::abs(b.distance); });
  for (const auto& target : targets)
    draw_target(canvas, labels, image, frame, target, target.index < names.size() ? names[target.index] : "?");
}

}  // namespace tissued::daemon
