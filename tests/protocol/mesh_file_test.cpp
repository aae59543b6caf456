#include "protocol/mesh_file.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <sstream>
#include <tuple>

#include "protocol/file_content.hpp"
#include "protocol/gmsh_file.hpp"
#include "protocol/mesh_check.hpp"
#include "tests/protocol/hand_meshes.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;
using Catch::Matchers::Contains;

namespace {

double volume_of(const MeshFile& mesh) {
  double volume = 0.0;
  for (const Tetrahedron& tet : mesh.tets) volume += signed_volume(mesh.nodes, tet);
  return volume;
}

// The volume inside all surface groups by the divergence theorem; their winding decides the sign.
double enclosed_volume(const MeshFile& mesh) {
  double volume = 0.0;
  for (const auto& [name, triangles] : mesh.surfaces) {
    for (const Triangle& triangle : triangles) {
      const auto& [a, b, c] = triangle;
      const auto& p = mesh.nodes[a];
      const auto& q = mesh.nodes[b];
      const auto& r = mesh.nodes[c];
      volume += (p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0]) +
                 p[2] * (q[0] * r[1] - q[1] * r[0])) /
                6.0;
    }
  }
  return volume;
}

bool has_shared_data() {
  if (std::filesystem::exists(TISSUED_SHARED_DATA)) return true;
  WARN("no shared data at " TISSUED_SHARED_DATA ", skipped");
  return false;
}

std::filesystem::path shared(const char* path) { return std::filesystem::path(TISSUED_SHARED_DATA) / path; }

// A box of nx * ny * nz cubes of 1 mm, six tetrahedra each, as Gmsh 2.2.
std::string box_as_gmsh2(int nx, int ny, int nz) {
  const auto tag = [&](int i, int j, int k) { return 1 + i + (nx + 1) * (j + (ny + 1) * k); };
  std::ostringstream nodes;
  std::ostringstream tets;
  int count = 0;
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i) {
        nodes << tag(i, j, k) << ' ' << i << ' ' << j << ' ' << k << '\n';
        if (i == nx || j == ny || k == nz) continue;
        // One tetrahedron per order in which the three steps from one corner to the opposite one can be taken.
        for (const auto& [first, second, even] :
             {std::tuple{0, 1, true}, {1, 2, true}, {2, 0, true}, {1, 0, false}, {2, 1, false}, {0, 2, false}}) {
          std::array<std::array<int, 3>, 4> corner{};
          corner.fill({i, j, k});
          for (int c = 1; c < 4; ++c) ++corner[c][first];
          for (int c = 2; c < 4; ++c) ++corner[c][second];
          ++corner[3][3 - first - second];
          if (!even) std::swap(corner[1], corner[2]);
          tets << ++count << " 4 2 1 1";
          for (const auto& [x, y, z] : corner) tets << ' ' << tag(x, y, z);
          tets << '\n';
        }
      }
    }
  }
  std::ostringstream text;
  text << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << tag(nx, ny, nz) << '\n' << nodes.str();
  text << "$EndNodes\n$Elements\n" << count << '\n' << tets.str() << "$EndElements\n";
  return text.str();
}

}  // namespace

TEST_CASE("a mesh is read by its extension") {
  const TemporaryFolder folder;
  write_file_content(folder.path() / "a.msh", kGmsh2);
  write_file_content(folder.path() / "b.1.node", kTetgenNode);
  write_file_content(folder.path() / "b.1.ele", kTetgenEle);
  CHECK(read_mesh(folder.path() / "a.msh").surfaces.size() == 2);
  CHECK(read_mesh(folder.path() / "b.1.node").surfaces.empty());
  write_file_content(folder.path() / "b.1.face", kTetgenFace);
  const MeshFile mesh = read_mesh(folder.path() / "b.1.ele");
  CHECK(mesh.surfaces.size() == 2);
  CHECK(mesh.node_file == (folder.path() / "b.1.node").string());

  CHECK_THROWS_WITH(read_mesh(folder.path() / "c.msh"), Contains("c.msh: cannot be opened: No such file"));
  CHECK_THROWS_AS(read_mesh(folder.path() / "c.msh"), FileError);
  CHECK_THROWS_WITH(read_mesh(folder.path() / "c.stl"), Contains("'.stl' is no mesh format"));
  std::filesystem::remove(folder.path() / "b.1.node");
  CHECK_THROWS_WITH(read_mesh(folder.path() / "b.1.ele"), Contains("b.1.node: cannot be opened"));
  std::filesystem::create_directory(folder.path() / "d.msh");
  CHECK_THROWS_WITH(read_mesh(folder.path() / "d.msh"), Contains("is a folder"));
}

TEST_CASE("an error is one line of file, line and reason") {
  const MeshError error("a.msh", 7, "wrong");
  CHECK(std::string(error.what()) == "a.msh:7: wrong");
  CHECK(std::string(MeshError("a.msh", 0, "wrong").what()) == "a.msh: wrong");
  // Whatever bytes stand in the file, the message stays one printable line.
  try {
    parse_gmsh("$MeshFormat\n\x01\x02\t\xFF 0 8\n", "a.msh");
    FAIL("accepted");
  } catch (const MeshError& binary) {
    for (const char* c = binary.what(); *c != '\0'; ++c) CHECK((*c >= ' ' && *c <= '~'));
  }
}

TEST_CASE("a missing surface group is refused with the groups there are") {
  const MeshFile mesh = parse_gmsh(kGmsh2, "a.msh");
  CHECK(require_surface(mesh, "base") == mesh.surfaces.at("base"));
  CHECK_THROWS_WITH(require_surface(mesh, "A1"),
                    "a.msh: no triangles in a surface group 'A1'; there are 'base', 'skin'");
  CHECK_THROWS_AS(require_surface(mesh, "tissue"), MeshError);
}

TEST_CASE("a flat tetrahedron is told from a thin one by its size alone") {
  // Height over a right triangle with legs 1: volume / edge^3 = height / 6 / sqrt(8).
  for (const double size : {1e-6, 1.0, 1e6}) {
    for (const auto& [height, flat] : {std::pair{1.5e-6, true}, {2e-6, false}}) {
      MeshFile mesh;
      mesh.tet_file = mesh.node_file = "a.msh";
      mesh.nodes = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size * height}};
      mesh.tets = {{0, 1, 2, 3}};
      mesh.node_lines = {1, 2, 3, 4};
      mesh.tet_lines = {9};
      if (flat) {
        CHECK_THROWS_WITH(check_geometry(mesh, Winding::positive), Contains("a.msh:9: degenerate"));
      } else {
        CHECK_NOTHROW(check_geometry(mesh, Winding::positive));
      }
    }
  }
}

TEST_CASE("a large mesh fills its box") {
  const MeshFile mesh = parse_gmsh(box_as_gmsh2(20, 10, 5), "box.msh");
  CHECK(mesh.tets.size() == 6 * 20 * 10 * 5);
  CHECK(volume_of(mesh) == Approx(20.0 * 10.0 * 5.0).epsilon(1e-12));
}

TEST_CASE("the shared meshes have the stated size, volume and closed surfaces") {
  if (!has_shared_data()) return;
  const MeshFile dome = read_mesh(shared("reference/dome.msh"));
  CHECK(dome.nodes.size() == 601);
  CHECK(dome.tets.size() == 2142);
  CHECK(dome.surfaces.size() == 6);
  CHECK(require_surface(dome, "A1").size() == 28);
  CHECK(std::abs(enclosed_volume(dome)) == Approx(volume_of(dome)).epsilon(1e-9));
  // Chords of half an ellipsoid of 70, 70 and 60 mm stay a little below it.
  const double ellipsoid = 2.0 / 3.0 * std::numbers::pi * 70.0 * 70.0 * 60.0;
  CHECK(volume_of(dome) < ellipsoid);
  CHECK(volume_of(dome) > 0.96 * ellipsoid);

  const MeshFile box = read_mesh(shared("reference/box.msh"));
  CHECK(box.tets.size() == 2139);
  CHECK(volume_of(box) == Approx(155.0 * 100.0 * 70.0).epsilon(1e-9));
  CHECK(std::abs(enclosed_volume(box)) == Approx(155.0 * 100.0 * 70.0).epsilon(1e-9));

  const MeshFile beam = read_mesh(shared("real/beam/mesh.msh"));
  CHECK(volume_of(beam) == Approx(100.0 * 30.0 * 30.0).epsilon(1e-9));
  CHECK(beam.volumes.at("tissue").size() == beam.tets.size());
}
