#include "protocol/vtk_file.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "protocol/file_content.hpp"
#include "protocol/file_error.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued::protocol;

namespace {

const std::vector<std::array<double, 3>> kNodes{{0, 0, 0}, {10, 0, 0}, {0, 1.0 / 3.0, 0}, {0, 0, -1e-300}, {1, 2, 3}};
const std::vector<std::array<std::int32_t, 4>> kTets{{0, 1, 2, 3}, {1, 2, 3, 4}};
const std::vector<double> kDisplacement{0, 0, 0, 0.1, -0.2, 0.3, 1e-17, 2, 3, 4, 5, 6, 7, 8, 9.5};
const std::vector<double> kPressure{1, 2, 3, 4, 5};

}  // namespace

TEST_CASE("a .vtu is what Python's XML reader and the format's manual make of it") {
  const TemporaryFolder folder;
  const std::vector<PointField> fields{{"displacement", 3, kDisplacement}, {"<p> & \"q\"", 1, kPressure}};
  write_vtu(folder.path() / "a.vtu", kNodes, kTets, fields);
  const std::string out = (folder.path() / "out.txt").string();
  const std::string command = std::string(TISSUED_PYTHON) + " " + TISSUED_SOURCE_DIR "/tests/protocol/read_vtu.py " +
                              (folder.path() / "a.vtu").string() + " > " + out;
  REQUIRE(std::system(command.c_str()) == 0);

  std::istringstream values(read_file_content(out));
  std::string word;
  std::size_t points = 0;
  std::size_t cells = 0;
  values >> points >> cells;
  CHECK(points == kNodes.size());
  CHECK(cells == kTets.size());
  const auto check_numbers = [&](const std::string& name, const std::vector<double>& expected) {
    INFO(name);
    std::string line;
    std::getline(values >> std::ws, line);
    CHECK(line == name);
    for (const double number : expected) {
      values >> word;
      CHECK(std::strtod(word.c_str(), nullptr) == number);
    }
  };
  std::vector<double> coordinates;
  for (const auto& node : kNodes) coordinates.insert(coordinates.end(), node.begin(), node.end());
  check_numbers("Points 3 Float64", coordinates);
  check_numbers("connectivity 1 Int32", {0, 1, 2, 3, 1, 2, 3, 4});
  check_numbers("offsets 1 Int32", {4, 8});
  check_numbers("types 1 UInt8", {10, 10});
  check_numbers("displacement 3 Float64", kDisplacement);
  check_numbers("<p> & \"q\" 1 Float64", kPressure);
  CHECK_FALSE(values >> word);
}

TEST_CASE("what a .vtu cannot hold is not written") {
  const std::vector<PointField> wrong_size{{"u", 3, kPressure}};
  CHECK_THROWS_AS(format_vtu(kNodes, kTets, wrong_size), std::invalid_argument);
  const std::vector<PointField> no_components{{"u", 0, {}}};
  CHECK_THROWS_AS(format_vtu(kNodes, kTets, no_components), std::invalid_argument);
  auto values = kPressure;
  values[2] = std::numeric_limits<double>::quiet_NaN();
  const std::vector<PointField> not_finite{{"u", 1, values}};
  CHECK_THROWS_AS(format_vtu(kNodes, kTets, not_finite), std::invalid_argument);
  for (const std::int32_t node : {-1, 5}) {
    const std::vector<std::array<std::int32_t, 4>> tets{{0, 1, 2, node}};
    CHECK_THROWS_AS(format_vtu(kNodes, tets, {}), std::invalid_argument);
  }
  CHECK_THROWS_AS(write_vtu("/nowhere/at/all.vtu", kNodes, kTets, {}), FileError);
}
