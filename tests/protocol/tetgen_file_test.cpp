#include "protocol/tetgen_file.hpp"

#include <catch2/catch.hpp>

#include "protocol/gmsh_file.hpp"
#include "tests/protocol/hand_meshes.hpp"
#include "tests/protocol/text_edit.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;
using Catch::Matchers::Contains;

namespace {

MeshFile parse(const std::string& node, const std::string& ele, const std::string& face = kTetgenFace) {
  return parse_tetgen({"a.node", node}, {"a.ele", ele}, TetgenText{"a.face", face});
}

enum class File { node, ele, face };

struct Refusal {
  File file;
  const char* from;
  const char* to;
  int line;
  const char* reason;
};

}  // namespace

TEST_CASE("a TetGen set gives the same mesh as the Gmsh files") {
  const MeshFile tetgen = parse(kTetgenNode, kTetgenEle);
  const MeshFile gmsh = parse_gmsh(kGmsh2, "a.msh");
  CHECK(tetgen.nodes == gmsh.nodes);
  CHECK(tetgen.tets == gmsh.tets);
  CHECK(tetgen.surfaces.size() == 2);
  CHECK(tetgen.surfaces.at("21") == gmsh.surfaces.at("base"));
  CHECK(tetgen.surfaces.at("22") == gmsh.surfaces.at("skin"));
  CHECK(tetgen.volumes.at("31") == gmsh.volumes.at("tissue"));
  CHECK_FALSE(tetgen.orientation_reversed);
  CHECK(tetgen.node_file == "a.node");
  CHECK(tetgen.tet_file == "a.ele");
  CHECK(tetgen.node_lines == std::vector<int>{4, 5, 6, 7, 8});
  CHECK(tetgen.tet_lines == std::vector<int>{2, 3});
}

TEST_CASE("TetGen numbers from 0 or from 1") {
  const std::string node = "5 3 0 0\n1 0 0 0\n2 10 0 0\n3 0 10 0\n4 0 0 10\n5 10 10 10\n";
  const MeshFile mesh = parse(node, "2 4 0\n1 1 2 3 4\n2 2 3 4 5\n", "1 0\n1 1 3 2\n");
  const MeshFile from_zero = parse(kTetgenNode, kTetgenEle);
  CHECK(mesh.nodes == from_zero.nodes);
  CHECK(mesh.tets == from_zero.tets);
  // Without markers and attributes there are no groups.
  CHECK(mesh.surfaces.empty());
  CHECK(mesh.volumes.empty());
}

TEST_CASE("a TetGen set without faces has no surfaces") {
  const MeshFile mesh = parse_tetgen({"a.node", kTetgenNode}, {"a.ele", kTetgenEle}, std::nullopt);
  CHECK(mesh.tets.size() == 2);
  CHECK_THROWS_WITH(require_surface(mesh, "21"), "a.ele: no triangles in a surface group '21'; there are none");
}

TEST_CASE("Windows line ends and the neighbours that tetgen -nn writes change nothing") {
  const MeshFile mesh = parse(with_crlf(kTetgenNode), with_crlf(kTetgenEle), "1 1\n0 0 2 1 21 0 -1\n");
  CHECK(mesh.nodes == parse(kTetgenNode, kTetgenEle).nodes);
  CHECK(mesh.surfaces.at("21") == std::vector<Triangle>{{0, 2, 1}});
}

TEST_CASE("TetGen tetrahedra all wound the other way are turned over, a mixture is refused") {
  const std::string reversed = "2 4 0\n0 1 0 2 3\n1 2 1 3 4\n";
  const MeshFile mesh = parse(kTetgenNode, reversed);
  CHECK(mesh.orientation_reversed);
  CHECK(mesh.tets == std::vector<Tetrahedron>{{1, 0, 3, 2}, {2, 1, 4, 3}});
  for (const Tetrahedron& tet : mesh.tets) {
    const auto& a = mesh.nodes[tet[0]];
    std::array<std::array<double, 3>, 3> edges{};
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) edges[i][k] = mesh.nodes[tet[i + 1]][k] - a[k];
    }
    const auto& [u, v, w] = edges;
    const double determinant =
        u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
    CHECK(determinant > 0.0);
  }
  try {
    parse(kTetgenNode, "2 4 0\n0 0 1 2 3\n1 2 1 3 4\n");
    FAIL("accepted");
  } catch (const MeshError& error) {
    CHECK(error.file() == "a.ele");
    CHECK(error.line() == 3);
    CHECK_THAT(error.reason(), Contains("inverted"));
  }
}

TEST_CASE("a mixture is blamed on the smaller part") {
  // A third tetrahedron on the far side of the second.
  const std::string node = "6 3 0 0\n0 0 0 0\n1 10 0 0\n2 0 10 0\n3 0 0 10\n4 10 10 10\n5 10 10 0\n";
  // Negative, positive, negative: the second is the odd one out.
  const std::string ele = "3 4 0\n0 1 0 2 3\n1 1 2 3 4\n2 1 2 5 4\n";
  try {
    parse(node, ele);
    FAIL("accepted");
  } catch (const MeshError& error) {
    CHECK(error.line() == 3);
    CHECK_THAT(error.reason(), Contains("the first of 1 wound this way among 3"));
  }
}

TEST_CASE("a bad TetGen set is refused at its file and line") {
  const std::vector<Refusal> refusals{
      {File::node, "5 3 1 1", "5 2 1 1", 2, "dimension must be 3"},
      {File::node, "5 3 1 1", "5 3 1 2", 2, "boundary markers must be 0 or 1"},
      {File::node, "5 3 1 1", "6 3 1 1", 8, "ends before point 6 of 6"},
      {File::node, "5 3 1 1", "4 3 1 1", 8, "more than the 4 points"},
      {File::node, "5 3 1 1", "500000 3 1 1", 2, "more than the rest"},
      {File::node, "5 3 1 1", "5 3 9999 1", 2, "more than the rest"},
      {File::node, "5 3 1 1", "5 3 1 1 1", 2, "more than this line"},
      {File::node, "5 3 1 1", "5 3 2 1", 4, "ends before the boundary marker"},
      {File::node, "0  0 0 0", "2  0 0 0", 4, "numbered from 0 or 1"},
      {File::node, "0  0 0 0", "1  0 0 0", 5, "point number 1 where 2 should be"},
      {File::node, "3  0 0 10", "2  0 0 10", 7, "point number 2 where 3 should be"},
      {File::node, "3  0 0 10", "3  0 0 nan", 7, "'nan' is not a finite number"},
      {File::node, "3  0 0 10", "3  0 0 # 10", 7, "ends before the z"},
      {File::ele, "2 4 1", "2 10 1", 1, "tetrahedra of 10 nodes"},
      {File::ele, "2 4 1", "3 4 1", 4, "ends before tetrahedron 3 of 3"},
      {File::ele, "2 4 1", "1 4 1", 3, "more than the 1 tetrahedra"},
      {File::ele, "2 4 1", "0 4 1", 2, "more than the 0 tetrahedra"},
      {File::ele, "2 4 1", "-2 4 1", 1, "negative"},
      {File::ele, "2 4 1", "2 4 7", 1, "region attribute must be 0 or 1"},
      {File::ele, "0 1 2 3  31", "0 1 2 3  1.5", 2, "'1.5' is not an integer"},
      {File::ele, "0 1 2 3  31", "0 1 2 9  31", 2, "unknown node 9"},
      {File::ele, "0 1 2 3  31", "0 1 2 2  31", 2, "node 2 is named twice"},
      {File::ele, "1 2 3 4  31", "3 2 1 0  31", 3, "repeats the one of line 2"},
      {File::ele, "1  1 2 3 4", "2  1 2 3 4", 3, "tetrahedron number 2 where 1 should be"},
      {File::face, "3 1", "4 1", 4, "ends before face 4 of 4"},
      {File::face, "3 1", "2 1", 4, "more than the 2 faces"},
      {File::face, "1 2 4  22", "1 2 9  22", 3, "unknown node 9"},
      {File::face, "1 2 4  22", "1 2 2  22", 3, "named twice"},
      {File::face, "1 2 4  22", "1 2 4  x", 3, "'x' is not an integer"},
      {File::face, "1 2 4  22", "1 2 4  22 0 1 2", 3, "more than this line"},
  };
  const std::array<std::string, 3> names{"a.node", "a.ele", "a.face"};
  for (const Refusal& refusal : refusals) {
    INFO("'" << refusal.from << "' -> '" << refusal.to << "'");
    std::array<std::string, 3> texts{kTetgenNode, kTetgenEle, kTetgenFace};
    std::string& text = texts[static_cast<std::size_t>(refusal.file)];
    text = edited(text, refusal.from, refusal.to);
    try {
      parse(texts[0], texts[1], texts[2]);
      FAIL_CHECK("accepted");
    } catch (const MeshError& error) {
      CHECK(error.file() == names[static_cast<std::size_t>(refusal.file)]);
      CHECK(error.line() == refusal.line);
      CHECK_THAT(error.reason(), Contains(refusal.reason));
    }
  }
  CHECK_THROWS_WITH(parse(kTetgenNode, "0 4 0\n"), "a.ele: no tetrahedra");
  CHECK_THROWS_WITH(parse("", kTetgenEle), "a.node: the file ends before the number of points");
}

TEST_CASE("a point of no tetrahedron is refused at its line") {
  try {
    parse(kTetgenNode, "1 4 0\n0 0 1 2 3\n");
    FAIL("accepted");
  } catch (const MeshError& error) {
    CHECK(error.file() == "a.node");
    CHECK(error.line() == 8);
    CHECK_THAT(error.reason(), Contains("unreferenced"));
  }
}

TEST_CASE("every truncation of a TetGen set is refused or leaves whole lines") {
  const std::array<std::string, 3> whole{kTetgenNode, kTetgenEle, kTetgenFace};
  for (std::size_t file = 0; file < whole.size(); ++file) {
    // Before the last digit of the last entry there is always something missing; a shorter last number is one, too.
    const std::size_t last_entry = whole[file].find_last_of('\n', whole[file].find_last_of("0123456789"));
    for (std::size_t length = 0; length < whole[file].size(); ++length) {
      std::array<std::string, 3> texts = whole;
      texts[file].resize(length);
      INFO("file " << file << " cut at " << length);
      if (length <= last_entry) {
        CHECK_THROWS_AS(parse(texts[0], texts[1], texts[2]), MeshError);
      } else {
        try {
          const MeshFile mesh = parse(texts[0], texts[1], texts[2]);
          CHECK(mesh.tets.size() == 2);
        } catch (const MeshError& error) {
          CHECK(error.line() > 0);
        }
      }
    }
  }
}
