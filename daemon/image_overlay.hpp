#pragma once

#include <string>
#include <vector>

#include "daemon/joined_view.hpp"
#include "daemon/rgb_image.hpp"

namespace tissued::daemon {

/// Draws the targets of a view on its ultrasound image: a disc where the target's foot is, a circle of 3 mm around it,
/// the ellipse that holds the foot with 95 %, the name and the distance from the plane. A target within 2 mm of the
/// plane, or as near as its uncertainty allows (95 %), is bright; one that is not is dashed and grows paler with its
/// distance, and points the way out of an image that it is beside. What is not valid is said in words on top, and in
/// colour: amber where it is degraded, red where it is invalid.
/// names: of the targets, by index. Throws std::runtime_error where the image is not of the size that the view says.
void draw_overlay(const JoinedView& view, const std::vector<std::string>& names, RgbImage& image);

/// Whether the view shows the target as lying in the image's plane.
bool is_in_plane(const protocol::ImageTarget& target);

}  // namespace tissued::daemon
