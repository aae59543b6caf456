#pragma once

#include <array>
#include <vector>

namespace tissued::daemon {

inline constexpr int kGlyphRows = 7;     ///< of a capital letter; one more below the line
inline constexpr int kGlyphAdvance = 6;  ///< columns from one letter to the next

/// x and y of both ends, columns and rows from the letter's upper left corner.
using GlyphLine = std::array<int, 4>;

/// The lines of a letter: the neighbours among the dots of a matrix of 5 x 8, joined. Blank for what is not printable
/// ASCII.
std::vector<GlyphLine> glyph_lines(char letter);

}  // namespace tissued::daemon
