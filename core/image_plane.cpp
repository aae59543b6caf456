#include "core/image_plane.hpp"

#include <algorithm>
#include <cmath>

namespace tissued::core {

ImagePoint project(const ImagePlane& image, const RigidTransform& a_T_probe, const Vec3& position,
                   const Mat3& covariance) {
  const RigidTransform image_T_a = (a_T_probe * image.probe_T_image).inverse();
  const Vec3 at = image_T_a(position);
  const Mat3 spread = image_T_a.rotation * covariance * image_T_a.rotation.transpose();
  const Eigen::Vector2d per_mm = image.spacing.cwiseInverse();
  ImagePoint point;
  point.pixel = at.head<2>().cwiseProduct(per_mm);
  point.covariance = per_mm.asDiagonal() * spread.topLeftCorner<2, 2>() * per_mm.asDiagonal();
  point.distance = at.z();
  point.distance_sd = std::sqrt(std::max(spread(2, 2), 0.0));
  // A pixel reaches half a pixel beyond its centre.
  const Eigen::Vector2d last = image.size.cast<double>().array() - 0.5;
  point.inside = (point.pixel.array() >= -0.5).all() && (point.pixel.array() <= last.array()).all();
  return point;
}

Ellipse ellipse_of(const Eigen::Matrix2d& covariance) {
  const double mean = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double half = 0.5 * (covariance(0, 0) - covariance(1, 1)), off = covariance(0, 1);
  const double apart = std::hypot(half, off);
  Ellipse ellipse;
  ellipse.major = std::sqrt(std::max(mean + apart, 0.0));
  ellipse.minor = std::sqrt(std::max(mean - apart, 0.0));
  ellipse.angle = 0.5 * std::atan2(off, half);
  return ellipse;
}

}  // namespace tissued::core
