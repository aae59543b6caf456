#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace tissued::daemon {

using Rgb = std::array<std::uint8_t, 3>;

/// Rows from the top, pixels from the left.
struct RgbImage {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  std::vector<Rgb> pixels;

  Rgb& at(int column, int row) {
    return pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
  }
  const Rgb& at(int column, int row) const { return const_cast<RgbImage*>(this)->at(column, row); }
};

/// Greys and palettes become RGB, transparency lies on black. Throws std::runtime_error that names the file: not a PNG,
/// or beyond 16384 pixels a side.
RgbImage read_png(const std::filesystem::path& path);
/// Throws std::runtime_error that names the file.
void write_png(const RgbImage& image, const std::filesystem::path& path);

}  // namespace tissued::daemon
