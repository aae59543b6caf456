#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "protocol/file_error.hpp"

namespace tissued::protocol {

/// A mesh whose content is refused; line() is the line of the node, element or section at fault.
class MeshError : public FileError {
 public:
  using FileError::FileError;
};

using Triangle = std::array<std::int32_t, 3>;
using Tetrahedron = std::array<std::int32_t, 4>;

/// A tetrahedral mesh as its file gives it. All node indices count from 0 in the order of the file.
///
/// Every mesh handed out has passed the checks of mesh_check.hpp: all coordinates finite, every tetrahedron of
/// positive volume, none twice, every node in a tetrahedron.
struct MeshFile {
  std::string node_file;  ///< the file that node_lines count in
  std::string tet_file;   ///< the file that tet_lines count in; the same one for Gmsh

  std::vector<std::array<double, 3>> nodes;  ///< (n x 3) mm
  std::vector<int> node_lines;               ///< (n) line of every node in node_file, from 1
  std::vector<Tetrahedron> tets;             ///< (t x 4) node indices, positive volume (b - a) x (c - a) . (d - a)
  std::vector<int> tet_lines;                ///< (t) line of every tetrahedron in tet_file, from 1

  /// Group name -> its triangles (node indices, wound as in the file). Gmsh: physical surfaces, the tag in decimal
  /// where it has no name; TetGen: boundary markers of .face in decimal. Only groups that hold triangles.
  std::map<std::string, std::vector<Triangle>> surfaces;

  /// Group name -> indices into tets. Gmsh: physical volumes; TetGen: region attributes of .ele.
  std::map<std::string, std::vector<std::int32_t>> volumes;

  /// The file wound every tetrahedron the other way round; two nodes of each were swapped. TetGen only.
  bool orientation_reversed = false;
};

/// Reads a mesh by its extension: `.msh` (Gmsh 2.2 or 4.1, ASCII), or `.node` or `.ele` (a TetGen pair, with `.face`
/// where it exists). Throws MeshError for content that is refused, FileError where a file cannot be read.
MeshFile read_mesh(const std::filesystem::path& path);

/// The triangles of the surface group `name`; throws MeshError that lists the groups there are if it is missing.
const std::vector<Triangle>& require_surface(const MeshFile& mesh, const std::string& name);

}  // namespace tissued::protocol
