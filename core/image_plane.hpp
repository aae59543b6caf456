// The image of an ultrasound probe as a plane in space, and what is seen where on it.
//
// PLUS's convention: the image's frame has its origin at the centre of the first pixel, x to the right along the
// columns, y down along the rows and z out of the plane, right handed; world_T_image = world_T_probe * probe_T_image.
#pragma once

#include "core/rigid_transform.hpp"
#include "core/types.hpp"

namespace tissued::core {

// A probe's spatial calibration.
struct ImagePlane {
  RigidTransform probe_T_image;                       // mm
  Eigen::Vector2d spacing = Eigen::Vector2d::Ones();  // mm/pixel, from column to column and from row to row
  Eigen::Vector2i size = Eigen::Vector2i(1, 1);       // pixels, columns and rows
};

// A point and its uncertainty as the image shows them.
struct ImagePoint {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();       // u along columns, v along rows, of the point's foot
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // pixels^2, of the foot
  double distance = 0.0;                                 // mm, from the plane along z
  double distance_sd = 0.0;                              // mm
  bool inside = false;                                   // the foot lies on a pixel of the image
};

// position: mm, covariance: mm^2, in the frame a. The map is affine, so the covariance is exact.
ImagePoint project(const ImagePlane& image, const RigidTransform& a_T_probe, const Vec3& position,
                   const Mat3& covariance);

// Where the covariance's distance from its centre is one standard deviation.
struct Ellipse {
  double major = 0.0, minor = 0.0;  // half axes, in the covariance's unit
  double angle = 0.0;               // rad, of the major axis, from u towards v; in (-pi/2, pi/2]
};
// covariance: symmetric; what rounding leaves below zero counts as zero.
Ellipse ellipse_of(const Eigen::Matrix2d& covariance);

}  // namespace tissued::core
