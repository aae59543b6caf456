#include "protocol/gmsh_file.hpp"

#include <catch2/catch.hpp>

#include "tests/protocol/hand_meshes.hpp"
#include "tests/protocol/text_edit.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;
using Catch::Matchers::Contains;

namespace {

const std::vector<std::array<double, 3>> kNodes{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}, {10, 10, 10}};
const std::vector<Tetrahedron> kTets{{0, 1, 2, 3}, {1, 2, 3, 4}};
const std::map<std::string, std::vector<Triangle>> kSurfaces{{"base", {{0, 2, 1}}}, {"skin", {{1, 2, 4}, {2, 3, 4}}}};
const std::map<std::string, std::vector<std::int32_t>> kVolumes{{"tissue", {0, 1}}};

void check_hand_mesh(const MeshFile& mesh) {
  CHECK(mesh.nodes == kNodes);
  CHECK(mesh.tets == kTets);
  CHECK(mesh.surfaces == kSurfaces);
  CHECK(mesh.volumes == kVolumes);
  CHECK_FALSE(mesh.orientation_reversed);
}

const std::string kManyGroups = [] {
  std::string line = "10 10 10 65";
  for (int group = 1; group <= 65; ++group) line.append(" ").append(std::to_string(group));
  return line + " 0";
}();

struct Refusal {
  const char* from;
  const char* to;
  int line;
  const char* reason;
};

void check_refusals(const std::string& text, const std::vector<Refusal>& refusals) {
  for (const Refusal& refusal : refusals) {
    INFO("'" << refusal.from << "' -> '" << refusal.to << "'");
    try {
      parse_gmsh(edited(text, refusal.from, refusal.to), "a.msh");
      FAIL_CHECK("accepted");
    } catch (const MeshError& error) {
      CHECK(error.line() == refusal.line);
      CHECK_THAT(error.reason(), Contains(refusal.reason));
      CHECK(error.file() == "a.msh");
    }
  }
}

}  // namespace

TEST_CASE("both Gmsh versions give the mesh written by hand") {
  const MeshFile two = parse_gmsh(kGmsh2, "two.msh");
  check_hand_mesh(two);
  CHECK(two.node_lines == std::vector<int>{12, 13, 14, 15, 16});
  CHECK(two.tet_lines == std::vector<int>{25, 26});
  CHECK(two.tet_file == "two.msh");

  const MeshFile four = parse_gmsh(kGmsh4, "four.msh");
  check_hand_mesh(four);
  CHECK(four.node_lines == std::vector<int>{23, 24, 27, 31, 32});
  CHECK(four.tet_lines == std::vector<int>{46, 47});
}

TEST_CASE("Windows line ends, blank lines and unknown sections change nothing") {
  check_hand_mesh(parse_gmsh(with_crlf(kGmsh2), "a.msh"));
  check_hand_mesh(parse_gmsh(with_crlf(kGmsh4), "a.msh"));
  check_hand_mesh(parse_gmsh(edited(kGmsh2, "7 0 0 0\n", "\n \t\n7  0\t0 +0 \n"), "a.msh"));
  check_hand_mesh(parse_gmsh(kGmsh2 + "$NodeData\n1\n\"u\"\n$EndNodeData\n", "a.msh"));
}

TEST_CASE("an element of several physical groups belongs to each") {
  // As Gmsh 4.8 writes them: once per group in 2.2, a list of groups per entity in 4.1.
  const auto two = edited(edited(edited(kGmsh2, "$Elements\n7\n", "$Elements\n10\n"), "6 2 2 22 2 4 90 5\n",
                                 "6 2 2 22 2 4 90 5\n7 2 2 23 2 4 90 5\n"),
                          "9 4 2 31 1 3 4 90 5\n", "9 4 2 31 1 3 4 90 5\n10 4 2 77 1 3 4 90 5\n11 4 2 77 1 7 3 4 90\n");
  const auto four = edited(edited(kGmsh4, "10 10 10 1 22 0", "10 10 10 2 22 -23 0"), "1 31 2 1 2", "3 77 31 77 2 1 2");
  for (const std::string& text : {two, four}) {
    const MeshFile mesh = parse_gmsh(text, "a.msh");
    CHECK(mesh.tets == kTets);
    CHECK(mesh.volumes == std::map<std::string, std::vector<std::int32_t>>{{"77", {0, 1}}, {"tissue", {0, 1}}});
    REQUIRE(mesh.surfaces.size() == 3);
    CHECK(mesh.surfaces.at("23").back() == Triangle{2, 3, 4});
    CHECK(mesh.surfaces.at("skin") == kSurfaces.at("skin"));
  }
}

TEST_CASE("a 4.1 file without entities has no groups") {
  std::string text = kGmsh4;
  const std::size_t begin = text.find("$Entities");
  const std::size_t end = text.find("$Nodes");
  const MeshFile mesh = parse_gmsh(text.erase(begin, end - begin), "a.msh");
  CHECK(mesh.tets == kTets);
  CHECK(mesh.surfaces.empty());
  CHECK(mesh.volumes.empty());
}

TEST_CASE("a bad Gmsh 2.2 file is refused at its line") {
  check_refusals(kGmsh2,
                 {
                     {"$MeshFormat\n2", "$Nonsense\n2", 1, "not a Gmsh file"},
                     {"2.2 0 8", "2.2 1 8", 2, "binary"},
                     {"2.2 0 8", "2.1 0 8", 2, "only 2.2 and 4.1"},
                     {"2.2 0 8", "4 0 8", 2, "only 2.2 and 4.1"},
                     {"$EndMeshFormat", "$EndMesh", 3, "$EndMeshFormat"},
                     {"2 22 \"skin\"", "2 22 skin", 7, "double quotes"},
                     {"2 22 \"skin\"", "2 22 \"skin", 7, "double quotes"},
                     {"2 22 \"skin\"", "2 21 \"skin\"", 7, "named twice"},
                     {"2 22 \"skin\"", "2 22 \"base\"", 0, "both called 'base'"},
                     {"3\n2 21", "4\n2 21", 9, "name 4 of 4"},
                     {"3\n2 21", "2\n2 21", 8, "$EndPhysicalNames"},
                     {"$Nodes\n5", "$Nodes\nfive", 11, "'five' is not an integer"},
                     {"$Nodes\n5", "$Nodes\n-5", 11, "negative"},
                     {"$Nodes\n5", "$Nodes\n6", 17, "node 6 of 6"},
                     {"$Nodes\n5", "$Nodes\n4", 16, "where $EndNodes should be"},
                     {"$Nodes\n5", "$Nodes\n9999999999", 11, "more than the rest of the file can hold"},
                     {"$Nodes\n5", "$Nodes\n99999999999999999999", 11, "is not an integer"},
                     {"7 0 0 0", "7 0 0 nan", 12, "'nan' is not a finite number"},
                     {"7 0 0 0", "7 0 inf 0", 12, "'inf' is not a finite number"},
                     {"7 0 0 0", "7 0 1e999 0", 12, "'1e999' is not a finite number"},
                     {"7 0 0 0", "7 0 0 0x1", 12, "'0x1' is not a finite number"},
                     {"7 0 0 0", "7 0 0", 12, "ends before the z"},
                     {"7 0 0 0", "7 0 0 0 0", 12, "'0' is more than this line should hold"},
                     {"90 0 0 10.0", "4 0 0 10.0", 15, "node 4 was given in line 14 already"},
                     {"90 0 0 10.0", "91 0 0 10.0", 24, "unknown node 90"},
                     {"7 3 4 90\n", "7 3 4 6\n", 25, "unknown node 6"},
                     {"7 3 4 90\n", "7 3 4 3\n", 25, "node 3 is named twice"},
                     {"7 3 4 90\n", "7 3 4\n", 25, "ends before the node"},
                     {"7 3 4 90\n", "7 3 4 90 5\n", 25, "'5' is more than"},
                     {"7 3 4 90\n", "7 4 3 90\n", 25, "inverted"},
                     {"90 0 0 10.0", "90 0 0 -9", 25, "inverted"},
                     {"90 0 0 10.0", "90 3 3 1e-7", 25, "degenerate"},
                     {"90 0 0 10.0", "90 1e200 0 10", 25, "degenerate"},
                     {"9 4 2 31 1 3 4 90 5\n", "9 4 2 31 1 90 7 3 4\n", 26, "repeats the one of line 25"},
                     {"9 4 2 31 1 3 4 90 5\n", "9 1 2 31 1 3 4\n", 16, "unreferenced node"},
                     {"8 4 2", "8 11 2", 25, "quadratic"},
                     {"8 4 2", "8 5 2", 25, "hexahedron"},
                     {"8 4 2", "8 6 2", 25, "prism"},
                     {"8 4 2", "8 7 2", 25, "pyramid"},
                     {"8 4 2", "8 3 2", 25, "quadrangle"},
                     {"8 4 2", "8 92 2", 25, "type 92"},
                     {"8 4 2", "8 4 -2", 25, "negative"},
                     {"8 4 2", "8 4 999", 25, "more than the rest"},
                     {"8 4 2 31", "8 4 2 4000000000", 25, "out of range"},
                     {"$Elements\n7", "$Elements\n8", 27, "element 8 of 8"},
                     {"$Elements\n7", "$Elements\n6", 26, "where $EndElements should be"},
                     {"$EndNodes", "$EndNodes\n$Nodes\n0\n$EndNodes", 18, "a second section $Nodes"},
                     {"$Nodes\n", "$Elements\n0\n$EndElements\n$Nodes\n", 10, "$Elements before $Nodes"},
                     {"$EndElements\n", "$EndElements\nrubbish\n", 28, "'rubbish' where a section should start"},
                     {"$EndElements\n", "$EndElements\n$Periodic\n", 28, "the file ends before $EndPeriodic"},
                     {"$EndElements\n", "", 26, "the file ends before $EndElements"},
                 });
}

TEST_CASE("a bad Gmsh 4.1 file is refused at its line") {
  check_refusals(kGmsh4, {
                             {"4.1 0 8", "4.1 1 8", 2, "binary"},
                             {"4.1 0 8", "4.0 0 8", 2, "only 2.2 and 4.1"},
                             {"1 1 2 1\n1 0", "1 1 3 1\n1 0", 16, "entity 1 is given twice"},
                             {"1 1 2 1\n1 0", "1 1 1 1\n1 0", 16, "where $EndEntities should be"},
                             {"1 1 2 1\n1 0", "1 1 2 900\n1 0", 11, "more than the rest"},
                             {"10 10 10 1 22 0", "10 10 10 900 22 0", 15, "more than the rest"},
                             {"10 10 10 1 22 0", kManyGroups.c_str(), 15, "more than 64"},
                             {"10 10 10 1 22 0", "10 10 10 1 22", 15, "ends before the number of boundary entities"},
                             {"2 0 0 0 10 10 10 1 22 0", "1 0 0 0 10 10 10 1 22 0", 15, "entity 1 is given twice"},
                             {"3 5 3 90", "3 6 3 90", 33, "the blocks hold 5 nodes, the section says 6"},
                             {"3 5 3 90", "4 5 3 90", 33, "node block 4 of 4"},
                             {"3 5 3 90", "2 5 3 90", 28, "where $EndNodes should be"},
                             {"3 5 3 90", "3 5 3", 19, "ends before the greatest tag"},
                             {"3 5 3 90", "3 999999999 3 90", 19, "more than the rest"},
                             {"2 1 0 2\n7", "2 1 0 3\n7", 23, "more than this line"},
                             {"2 1 0 2\n7", "2 1 2 2\n7", 20, "parametric must be 0 or 1"},
                             {"2 1 0 2\n7", "4 1 0 2\n7", 20, "entity dimension 4"},
                             {"2 1 0 2\n7", "2 1 0 999999999\n7", 20, "more than the rest"},
                             {"0.5 0.5", "0.5", 27, "ends before the parameter"},
                             {"0.5 0.5", "0.5 0.5 0.5", 27, "more than this line"},
                             {"\n90\n5\n", "\n90\n7\n", 32, "node 7 was given in line 23 already"},
                             {"0 0 10\n", "0 0 1o\n", 31, "'1o' is not a finite number"},
                             {"5 7 1 9", "5 8 1 9", 48, "the blocks hold 7 elements, the section says 8"},
                             {"5 7 1 9", "4 7 1 9", 45, "where $EndElements should be"},
                             {"2 2 2 2\n", "2 3 2 2\n", 42, "entity 3 of dimension 2 is not in $Entities"},
                             {"2 2 2 2\n", "1 2 2 2\n", 42, "type 2 on an entity of dimension 1"},
                             {"2 2 2 2\n", "2 2 9 2\n", 42, "quadratic"},
                             {"3 1 4 2\n", "3 1 11 2\n", 45, "quadratic"},
                             {"9 3 4 90 5\n", "9 7 3 4 90\n", 47, "repeats the one of line 46"},
                             {"9 3 4 90 5\n", "9 3 4 90 6\n", 47, "unknown node 6"},
                             {"9 3 4 90 5\n", "9 4 3 90 5\n", 47, "inverted"},
                             {"9 3 4 90 5\n", "9 3 4 90 5 7\n", 47, "'7' is more than"},
                             {"$EndElements\n", "$EndElements\n$Entities\n", 49, "a second section $Entities"},
                         });
}

TEST_CASE("a Gmsh file without tetrahedra is refused") {
  const std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n";
  CHECK_THROWS_WITH(parse_gmsh(text, "a.msh"), "a.msh:7: the file ends before $Elements");
  CHECK_THROWS_WITH(parse_gmsh(text + "$Elements\n0\n$EndElements\n", "a.msh"), "a.msh: no tetrahedra");
  CHECK_THROWS_WITH(parse_gmsh("", "a.msh"), Contains("not a Gmsh file"));
}

TEST_CASE("every truncation of a Gmsh file is refused") {
  for (const std::string& text : {kGmsh2, kGmsh4}) {
    // The last byte is a line end, which a file may lack.
    for (std::size_t length = 0; length + 1 < text.size(); ++length) {
      CHECK_THROWS_AS(parse_gmsh(text.substr(0, length), "a.msh"), MeshError);
    }
    CHECK_NOTHROW(parse_gmsh(text.substr(0, text.size() - 1), "a.msh"));
  }
}

TEST_CASE("any byte of a Gmsh file may be wrong") {
  int accepted = 0;
  for (const std::string& text : {kGmsh2, kGmsh4}) {
    for (std::size_t at = 0; at < text.size(); ++at) {
      for (const char byte : {'\0', '\n', ' ', '-', '9', '$', '\xFF'}) {
        std::string corrupt = text;
        corrupt[at] = byte;
        try {
          const MeshFile mesh = parse_gmsh(corrupt, "a.msh");
          CHECK(mesh.tets.size() == 2);
          ++accepted;
        } catch (const MeshError& error) {
          CHECK(error.line() <= 49);
        }
      }
    }
  }
  // Most bytes matter; what is accepted is a changed number that is as good as the right one.
  CHECK(accepted > 0);
  CHECK(accepted < 2 * static_cast<int>(kGmsh2.size() + kGmsh4.size()));
}
