#include "daemon/rgb_image.hpp"

#include <png.h>

#include <stdexcept>
#include <string>

namespace tissued::daemon {
namespace {

constexpr unsigned kMostPixels = 16384;  // a side, as in the schema of bundles

// libpng's own structure, freed however a function ends.
struct PngHandle {
  png_image image{};
  PngHandle() { image.version = PNG_IMAGE_VERSION; }
  ~PngHandle() { png_image_free(&image); }
  PngHandle(const PngHandle&) = delete;
  PngHandle& operator=(const PngHandle&) = delete;
};

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& why) {
  throw std::runtime_error(path.string() + ": " + why);
}

}  // namespace

RgbImage read_png(const std::filesystem::path& path) {
  PngHandle png;
  if (png_image_begin_read_from_file(&png.image, path.c_str()) == 0) fail(path, png.image.message);
  if (png.image.width > kMostPixels || png.image.height > kMostPixels)
    fail(path, std::to_string(png.image.width) + " x " + std::to_string(png.image.height) +
                   " pixels are more than the maximum " + std::to_string(kMostPixels) + " a side");
  png.image.format = PNG_FORMAT_RGB;
  RgbImage image{static_cast<int>(png.image.width), static_cast<int>(png.image.height), {}};
  image.pixels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  const png_color black{0, 0, 0};
  if (png_image_finish_read(&png.image, &black, image.pixels.data(), 0, nullptr) == 0) fail(path, png.image.message);
  return image;
}

void write_png(const RgbImage& image, const std::filesystem::path& path) {
  PngHandle png;
  png.image.width = static_cast<png_uint_32>(image.width);
  png.image.height = static_cast<png_uint_32>(image.height);
  png.image.format = PNG_FORMAT_RGB;
  if (png_image_write_to_file(&png.image, path.c_str(), 0, image.pixels.data(), 0, nullptr) == 0)
    fail(path, png.image.message);
}

}  // namespace tissued::daemon
