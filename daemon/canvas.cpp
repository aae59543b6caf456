#include "daemon/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "daemon/glyphs.hpp"

namespace tissued::daemon {
namespace {

using Eigen::Vector2d;

double to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double square = along.squaredNorm();
  const double share = square > 0.0 ? std::clamp((p - a).dot(along) / square, 0.0, 1.0) : 0.0;
  return (p - a - share * along).norm();
}

}  // namespace

// distance: pixels, of a point outside of the shape; a pixel is covered from half a pixel inside to none outside.
template <typename Distance>
void Canvas::shade(const Vector2d& low, const Vector2d& high, const Stroke& stroke, const Distance& distance) {
  const auto bound = [](double value, int most) { return static_cast<int>(std::clamp(value, 0.0, most + 0.0)); };
  const int left = bound(std::floor(low.x()) - 1, image_->width), right = bound(std::ceil(high.x()) + 2, image_->width);
  const int top = bound(std::floor(low.y()) - 1, image_->height);
  const int bottom = bound(std::ceil(high.y()) + 2, image_->height);
  for (int row = top; row < bottom; ++row) {
    for (int column = left; column < right; ++column) {
      const double cover = stroke.opacity * std::clamp(0.5 - distance(Vector2d(column, row)), 0.0, 1.0);
      if (cover <= 0.0) continue;
      Rgb& pixel = image_->at(column, row);
      for (std::size_t channel = 0; channel < 3; ++channel)
        pixel[channel] =
            static_cast<std::uint8_t>(std::lround(pixel[channel] + cover * (stroke.colour[channel] - pixel[channel])));
    }
  }
}

void Canvas::draw_line(const Vector2d& from, const Vector2d& to, const Stroke& stroke) {
  const Vector2d reach = Vector2d::Constant(0.5 * stroke.width);
  shade(from.cwiseMin(to) - reach, from.cwiseMax(to) + reach, stroke,
        [&](const Vector2d& p) { return to_segment(p, from, to) - 0.5 * stroke.width; });
}

// As a closed run of short lines, so that what is thin stays as thin all around.
void Canvas::draw_ellipse(const Vector2d& center, const Vector2d& half_axes, double angle, const Stroke& stroke) {
  const Vector2d one = half_axes.x() * Vector2d(std::cos(angle), std::sin(angle));
  const Vector2d other = half_axes.y() * Vector2d(-std::sin(angle), std::cos(angle));
  const int pieces = std::clamp(static_cast<int>(4.0 * half_axes.maxCoeff()), 24, 720);
  const auto point = [&](int k) {
    const double at = 2.0 * std::numbers::pi * k / pieces;
    return Vector2d(center + std::cos(at) * one + std::sin(at) * other);
  };
  std::vector<Vector2d> dashes;  // two ends each
  double gone = 0.0;
  for (int k = 0; k < pieces; ++k) {
    const Vector2d from = point(k), to = point(k + 1);
    if (stroke.dash <= 0.0 || std::fmod(gone, 2.0 * stroke.dash) < stroke.dash) {
      dashes.push_back(from);
      dashes.push_back(to);
    }
    gone += (to - from).norm();
  }
  const Vector2d reach = (one.cwiseAbs2() + other.cwiseAbs2()).cwiseSqrt().array() + 0.5 * stroke.width;
  shade(center - reach, center + reach, stroke, [&](const Vector2d& p) {
    double least = INFINITY;
    for (std::size_t k = 0; k < dashes.size(); k += 2) least = std::min(least, to_segment(p, dashes[k], dashes[k + 1]));
    return least - 0.5 * stroke.width;
  });
}

void Canvas::fill_disc(const Vector2d& center, double radius, const Stroke& stroke) {
  const Vector2d reach = Vector2d::Constant(radius);
  shade(center - reach, center + reach, stroke, [&](const Vector2d& p) { return (p - center).norm() - radius; });
}

void Canvas::fill_box(const Vector2d& corner, const Vector2d& size, const Stroke& stroke) {
  const Vector2d middle = corner + 0.5 * size;
  shade(corner, corner + size, stroke,
        [&](const Vector2d& p) { return ((p - middle).cwiseAbs() - 0.5 * size).maxCoeff(); });
}

double Canvas::text_width(double height, std::string_view text) {
  return static_cast<double>(text.size()) * kGlyphAdvance * height / (kGlyphRows - 1);
}

void Canvas::draw_text(const Vector2d& place, double height, std::string_view text, const Stroke& stroke) {
  const double cell = height / (kGlyphRows - 1);
  const auto draw = [&](const Stroke& pen) {
    Vector2d at = place;
    for (const char c : text) {
      for (const GlyphLine& line : glyph_lines(c))
        draw_line(at + cell * Vector2d(line[0], line[1]), at + cell * Vector2d(line[2], line[3]), pen);
      at.x() += kGlyphAdvance * cell;
    }
  };
  const double width = std::max(1.0, 0.75 * cell);
  draw({{0, 0, 0}, width + 2.5, 0.6 * stroke.opacity, 0.0});
  draw({stroke.colour, width, stroke.opacity, 0.0});
}

}  // namespace tissued::daemon
