// What is drawn on ultrasound images, measured in the drawn pixels.
#include "daemon/image_overlay.hpp"

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <cmath>

#include "daemon/canvas.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

RgbImage black(int width, int height) {
  RgbImage image{width, height, {}};
  image.pixels.resize(static_cast<std::size_t>(width * height));
  return image;
}

// Brightness-weighted mean place of what is within `radius` of a place.
Eigen::Vector2d centre_of_light(const RgbImage& image, const Eigen::Vector2d& around, double radius) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weight = 0.0;
  for (int row = 0; row < image.height; ++row)
    for (int column = 0; column < image.width; ++column) {
      const Eigen::Vector2d p(column, row);
      if ((p - around).norm() > radius) continue;
      sum += image.at(column, row)[1] * p;
      weight += image.at(column, row)[1];
    }
  return sum / weight;
}

int brightest(const RgbImage& image) {
  int most = 0;
  for (const Rgb& pixel : image.pixels) most = std::max<int>(most, pixel[1]);
  return most;
}

JoinedView view_of(int width, int height) {
  JoinedView view;
  view.frame.validity = protocol::Validity::valid;
  view.frame.seen = view.frame.has_image = true;
  view.frame.size = {static_cast<std::uint16_t>(width), static_cast<std::uint16_t>(height)};
  view.frame.spacing = {0.1, 0.1};
  return view;
}

}  // namespace

TEST_CASE("a disc is where it is drawn, to a hundredth of a pixel, and as large") {
  for (const double shift : {0.0, 0.25, 0.5, 0.8}) {
    RgbImage image = black(60, 50);
    const Eigen::Vector2d place(29.0 + shift, 24.0 - 0.5 * shift);
    Canvas(image).fill_disc(place, 9.0, {});
    CHECK((centre_of_light(image, place, 20.0) - place).norm() < 0.01);
    double area = 0.0;
    for (const Rgb& pixel : image.pixels) area += pixel[1] / 255.0;
    CHECK(area == Approx(M_PI * 81.0).epsilon(0.01));
  }
}

TEST_CASE("an ellipse has its half axes along its angle") {
  RgbImage image = black(200, 200);
  const Eigen::Vector2d place(100.0, 100.0);
  constexpr double kAngle = 0.5;
  Canvas(image).draw_ellipse(place, {60.0, 25.0}, kAngle, {});
  const auto light = [&](double distance, double angle) {
    const Eigen::Vector2d p = place + distance * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    return image.at(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())))[1];
  };
  CHECK(light(60.0, kAngle) > 100);
  CHECK(light(25.0, kAngle + M_PI / 2) > 100);
  CHECK(light(56.0, kAngle) == 0);
  CHECK(light(64.0, kAngle) == 0);
  CHECK(light(60.0, -kAngle) == 0);
}

TEST_CASE("a target's disc is at its pixel, whatever else is drawn") {
  JoinedView view = view_of(380, 500);
  const Eigen::Vector2d place(140.3, 260.7);
  view.targets.push_back({0, true, {place.x(), place.y()}, 0.4, 0.2, {6.0, 3.0}, 0.3});
  RgbImage image = black(380, 500);
  draw_overlay(view, {"T1"}, image);
  CHECK((centre_of_light(image, place, 5.0) - place).norm() < 0.1);  // 0.01 mm
  // The circle, 3 mm.
  CHECK(image.at(140, 231)[1] + image.at(140, 230)[1] > 150);
  RgbImage again = black(380, 500);
  draw_overlay(view, {"T1"}, again);
  CHECK(again.pixels == image.pixels);
}

TEST_CASE("what is far from the plane is paler, what is not valid is another colour and said") {
  const auto drawn = [](double distance, protocol::Validity validity) {
    JoinedView view = view_of(380, 500);
    view.frame.validity = validity;
    view.targets.push_back({0, true, {150.0, 260.0}, distance, 0.2, {6.0, 3.0}, 0.3});
    RgbImage image = black(380, 500);
    draw_overlay(view, {"T1"}, image);
    return image;
  };
  using protocol::Validity;
  const RgbImage near = drawn(0.5, Validity::valid), far = drawn(20.0, Validity::valid);
  CHECK(brightest(near) > brightest(far) + 40);
  const Rgb disc = near.at(150, 260);
  CHECK((disc[1] > disc[0] && disc[1] > disc[2]));  // green
  const Rgb held = drawn(0.5, Validity::invalid).at(150, 260);
  CHECK((held[0] > 2 * held[1] && held[0] > 2 * held[2]));  // red
  const auto top = [](const RgbImage& image) {
    double light = 0.0;
    for (int row = 0; row < 30; ++row)
      for (int column = 0; column < image.width; ++column) light += image.at(column, row)[0];
    return light;
  };
  CHECK(top(near) == 0.0);
  CHECK(top(drawn(0.5, Validity::degraded)) > 1000.0);
}

TEST_CASE("targets are in the plane within 2 mm, or as near as they are known") {
  CHECK(is_in_plane({0, true, {}, 1.9, 0.1, {}, 0.0}));
  CHECK_FALSE(is_in_plane({0, true, {}, -2.1, 0.1, {}, 0.0}));
  CHECK(is_in_plane({0, true, {}, -5.0, 3.0, {}, 0.0}));
}

TEST_CASE("an image of another size than the calibration's is refused") {
  RgbImage image = black(300, 500);
  CHECK_THROWS_WITH(draw_overlay(view_of(380, 500), {}, image),
                    "the image has 300 x 500 pixels, the probe's calibration 380 x 500");
}

TEST_CASE("PNG files read back as they were written, and what is none is refused by name") {
  const TemporaryFolder folder;
  RgbImage image = black(7, 5);
  for (int k = 0; k < 35; ++k)
    image.pixels[static_cast<std::size_t>(k)] = {static_cast<std::uint8_t>(7 * k), static_cast<std::uint8_t>(k), 200};
  const auto file = folder.path() / "a.png";
  write_png(image, file);
  const RgbImage read = read_png(file);
  CHECK(read.width == 7);
  CHECK(read.height == 5);
  CHECK(read.pixels == image.pixels);
  CHECK_THROWS_WITH(read_png(folder.path() / "none.png"), Catch::Contains("none.png"));
}
