#pragma once

#include <array>

namespace tissued::daemon {

/// Red, green and blue (0 to 255) from the least mismatch to the most, evenly spaced: light to dark, so that it holds
/// in grey, too.
inline constexpr std::array<std::array<int, 3>, 5> kMismatchColours{
    {{255, 240, 180}, {254, 196, 88}, {244, 120, 48}, {206, 34, 36}, {128, 0, 38}}};

}  // namespace tissued::daemon
