#include "protocol/mesh_file.hpp"

#include <optional>

#include "protocol/file_content.hpp"
#include "protocol/gmsh_file.hpp"
#include "protocol/tetgen_file.hpp"
#include "protocol/text_fields.hpp"

namespace tissued::protocol {

namespace {

MeshFile read_tetgen(std::filesystem::path path) {
  const std::string node_name = path.replace_extension(".node").string();
  const std::string node_text = read_file_content(path);
  const std::string ele_name = path.replace_extension(".ele").string();
  const std::string ele_text = read_file_content(path);
  const std::string face_name = path.replace_extension(".face").string();
  if (!std::filesystem::exists(path)) return parse_tetgen({node_name, node_text}, {ele_name, ele_text}, std::nullopt);
  const std::string face_text = read_file_content(path);
  return parse_tetgen({node_name, node_text}, {ele_name, ele_text}, TetgenText{face_name, face_text});
}

}  // namespace

MeshFile read_mesh(const std::filesystem::path& path) {
  const std::filesystem::path extension = path.extension();
  if (extension == ".msh") return parse_gmsh(read_file_content(path), path.string());
  if (extension == ".node" || extension == ".ele") return read_tetgen(path);
  throw MeshError(path.string(), 0,
                  in_quotes(extension.string()) + " is no mesh format read here: .msh (Gmsh), .node or .ele (TetGen)");
}

const std::vector<Triangle>& require_surface(const MeshFile& mesh, const std::string& name) {
  const auto surface = mesh.surfaces.find(name);
  if (surface != mesh.surfaces.end()) return surface->second;
  std::string known;
  for (const auto& [other, triangles] : mesh.surfaces) known += (known.empty() ? "" : ", ") + in_quotes(other);
  throw MeshError(
      mesh.tet_file, 0,
      "no triangles in a surface group " + in_quotes(name) + "; there are " + (known.empty() ? "none" : known));
}

}  // namespace tissued::protocol
