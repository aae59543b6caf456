#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocol/prediction_messages.hpp"

namespace tissued::daemon {

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
