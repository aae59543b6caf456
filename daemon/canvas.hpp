#pragma once

#include <Eigen/Core>
#include <string_view>

#include "daemon/rgb_image.hpp"

namespace tissued::daemon {

/// How a line is drawn.
struct Stroke {
  Rgb colour{255, 255, 255};
  double width = 1.5;    ///< pixels
  double opacity = 1.0;  ///< 0 to 1
  double dash = 0.0;     ///< pixels, of a dash and of the gap behind it; 0: a whole line
};

/// Draws on an image with smooth edges: every pixel is covered by as much as its distance from the line says. (0, 0) is
/// the centre of the first pixel, x to the right, y down. What lies beyond the image is clipped.
class Canvas {
 public:
  /// The image outlives the canvas.
  explicit Canvas(RgbImage& image) : image_(&image) {}

  void draw_line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Stroke& stroke);
  /// half_axes: pixels, the first along `angle` (rad, from x towards y).
  void draw_ellipse(const Eigen::Vector2d& center, const Eigen::Vector2d& half_axes, double angle,
                    const Stroke& stroke);
  void fill_disc(const Eigen::Vector2d& center, double radius, const Stroke& stroke);
  void fill_box(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const Stroke& stroke);
  /// place: of the text's upper left corner. height: pixels, of a capital letter. On a dark rim, to be read anywhere.
  /// What is not printable ASCII is left out as a blank.
  void draw_text(const Eigen::Vector2d& place, double height, std::string_view text, const Stroke& stroke);
  static double text_width(double height, std::string_view text);

 private:
  template <typename Distance>
  void shade(const Eigen::Vector2d& low, const Eigen::Vector2d& high, const Stroke& stroke, const Distance& distance);

  RgbImage* image_;
};

}  // namespace tissued::daemon
