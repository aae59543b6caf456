#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/types.hpp"
#include "protocol/prediction_messages.hpp"

namespace tissued::daemon {

/// What the squared error of a point in space, normalized by its covariance, does not exceed in 95 % of cases: chi
/// square with 3 degrees of freedom.
inline constexpr double kChiSquare95 = 7.814727903251179;

/// error^T covariance^-1 error (the NEES; 3 on average where the covariance is right). error: mm. covariance: mm^2, xx,
/// xy, xz, yy, yz, zz. nullopt where it is zero: nothing is claimed (open loop).
std::optional<double> normalized_square(const core::Vec3& error, const std::array<double, 6>& covariance);

/// mm; the longest semi-axis of the ellipsoid that holds 95 % of a normal distribution in space. covariance: mm^2, xx,
/// xy, xz, yy, yz, zz. nullopt where it is zero: nothing is claimed (open loop).
std::optional<double> radius_95(const std::array<double, 6>& covariance);

/// mm; distance to the true place; nullopt where none was streamed.
std::optional<double> error_of(const protocol::TargetPrediction& prediction);

/// Whether the true place lies in that ellipsoid; nullopt where there is no truth or nothing is claimed.
std::optional<bool> inside_95(const protocol::TargetPrediction& prediction);

/// Names of the set bits of protocol::ValidityReason.
std::vector<std::string> reason_names(std::uint16_t reasons);

}  // namespace tissued::daemon
