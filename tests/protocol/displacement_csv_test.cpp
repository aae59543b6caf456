#include "protocol/displacement_csv.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "protocol/mesh_file.hpp"
#include "tests/protocol/text_edit.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;
using Catch::Matchers::Contains;
using Vector = std::array<double, 3>;

namespace {

const std::string kTable =
    "x,y,z,ux,uy,uz\n"
    "-77.500000000,-50.000000000,28.0,-1.167593341,-0.286887473,-0.096764723\n"
    "1,2,3,4,5,6\n";

}  // namespace

TEST_CASE("a displacement table is read as written by hand") {
  for (const std::string& text : {kTable, with_crlf(kTable), kTable + "\n,,,,,\n"}) {
    const DisplacementTable table = parse_displacement_csv(text, "a.csv");
    CHECK(table.rest == std::vector<Vector>{{-77.5, -50, 28}, {1, 2, 3}});
    CHECK(table.displacement == std::vector<Vector>{{-1.167593341, -0.286887473, -0.096764723}, {4, 5, 6}});
  }
}

TEST_CASE("a bad displacement table is refused at its line") {
  CHECK_THROWS_WITH(parse_displacement_csv("", "a.csv"), Contains("a.csv: the table must start with"));
  CHECK_THROWS_WITH(parse_displacement_csv(edited(kTable, "uz", "vz"), "a.csv"), Contains("a.csv:1: the table"));
  CHECK_THROWS_WITH(parse_displacement_csv(edited(kTable, "z,ux", "ux"), "a.csv"), Contains("a.csv:1: the table"));
  CHECK_THROWS_WITH(parse_displacement_csv(edited(kTable, "4,5,6", "4,5"), "a.csv"),
                    "a.csv:3: 5 cells where 6 should be");
  CHECK_THROWS_WITH(parse_displacement_csv(edited(kTable, "4,5,6", "4,5,6,7"), "a.csv"), Contains("a.csv:3: 7 cells"));
  CHECK_THROWS_WITH(parse_displacement_csv(edited(kTable, "4,5,6", "4,nan,6"), "a.csv"),
                    "a.csv:3: column 5 (uy): 'nan' is not a finite number");
  CHECK_THROWS_WITH(parse_displacement_csv(edited(kTable, "4,5,6", ",5,6"), "a.csv"),
                    "a.csv:3: column 4 (ux): '' is not a finite number");
}

TEST_CASE("a displacement table reads back to the same bits") {
  DisplacementTable table = parse_displacement_csv(kTable, "a.csv");
  table.rest[1] = {1.0 / 3.0, -0.0, 1e-300};
  const TemporaryFolder folder;
  write_displacement_csv(table, folder.path() / "b.csv");
  const DisplacementTable read = read_displacement_csv(folder.path() / "b.csv");
  CHECK(read.rest == table.rest);
  CHECK(read.displacement == table.displacement);
  CHECK(std::signbit(read.rest[1][1]));
  table.rest.pop_back();
  CHECK_THROWS_AS(format_displacement_csv(table), std::invalid_argument);
}

TEST_CASE("the reference answers lie on the nodes of their mesh") {
  const std::filesystem::path folder = std::filesystem::path(TISSUED_SHARED_DATA) / "reference";
  if (!std::filesystem::exists(folder)) {
    WARN("no shared data at " << folder << ", skipped");
    return;
  }
  const MeshFile mesh = read_mesh(folder / "dome.msh");
  const DisplacementTable table = read_displacement_csv(folder / "dome-a1-10.csv");
  REQUIRE(table.rest.size() == mesh.nodes.size());
  for (const Vector& rest : table.rest) {
    double nearest = 1e9;
    for (const Vector& node : mesh.nodes) {
      nearest = std::min(nearest, std::hypot(node[0] - rest[0], node[1] - rest[1], node[2] - rest[2]));
    }
    CHECK(nearest < 1e-8);
  }
}
