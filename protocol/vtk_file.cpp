#include "protocol/vtk_file.hpp"

#include <cmath>
#include <stdexcept>

#include "protocol/file_content.hpp"
#include "protocol/text_fields.hpp"

namespace tissued::protocol {

namespace {

using Node = std::array<double, 3>;
using Tet = std::array<std::int32_t, 4>;

constexpr int kVtkTetra = 10;

// What stands inside an XML attribute.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

void append_finite(std::string& text, double value, const std::string& name) {
  if (!std::isfinite(value)) throw std::invalid_argument("a value of " + in_quotes(name) + " is not finite");
  append_number(text, value);
}

void open_array(std::string& text, const char* type, const std::string& name, int components) {
  text.append("<DataArray type=\"").append(type).append("\" Name=\"").append(escaped(name));
  text.append("\" NumberOfComponents=\"").append(std::to_string(components)).append("\" format=\"ascii\">\n");
}

void close_array(std::string& text) { text += "</DataArray>\n"; }

void append_nodes(std::string& text, std::span<const Node> nodes) {
  text += "<Points>\n";
  open_array(text, "Float64", "Points", 3);
  for (const Node& node : nodes) {
    for (const double value : node) {
      append_finite(text, value, "Points");
      text += ' ';
    }
    text.back() = '\n';
  }
  close_array(text);
  text += "</Points>\n";
}

void append_tets(std::string& text, std::span<const Tet> tets, std::size_t nodes) {
  text += "<Cells>\n";
  open_array(text, "Int32", "connectivity", 1);
  for (const Tet& tet : tets) {
    for (const std::int32_t node : tet) {
      if (node < 0 || static_cast<std::size_t>(node) >= nodes) {
        throw std::invalid_argument("a tetrahedron names node " + std::to_string(node) + " of " +
                                    std::to_string(nodes));
      }
      text.append(std::to_string(node)).append(" ");
    }
    text.back() = '\n';
  }
  close_array(text);
  open_array(text, "Int32", "offsets", 1);
  for (std::size_t i = 1; i <= tets.size(); ++i) text.append(std::to_string(4 * i)).append("\n");
  close_array(text);
  open_array(text, "UInt8", "types", 1);
  for (std::size_t i = 0; i < tets.size(); ++i) text.append(std::to_string(kVtkTetra)).append("\n");
  close_array(text);
  text += "</Cells>\n";
}

void append_field(std::string& text, const PointField& field, std::size_t nodes) {
  if (field.components < 1 || field.values.size() != nodes * static_cast<std::size_t>(field.components)) {
    throw std::invalid_argument("the field " + in_quotes(field.name) + " has " + std::to_string(field.values.size()) +
                                " values, not " + std::to_string(field.components) + " for each of " +
                                std::to_string(nodes) + " nodes");
  }
  open_array(text, "Float64", field.name, field.components);
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    append_finite(text, field.values[i], field.name);
    text += (i + 1) % static_cast<std::size_t>(field.components) == 0 ? '\n' : ' ';
  }
  close_array(text);
}

}  // namespace

std::string format_vtu(std::span<const Node> nodes, std::span<const Tet> tets, std::span<const PointField> fields) {
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "<UnstructuredGrid>\n";
  text.append("<Piece NumberOfPoints=\"").append(std::to_string(nodes.size()));
  text.append("\" NumberOfCells=\"").append(std::to_string(tets.size())).append("\">\n");
  text += "<PointData>\n";
  for (const PointField& field : fields) append_field(text, field, nodes.size());
  text += "</PointData>\n";
  append_nodes(text, nodes);
  append_tets(text, tets, nodes.size());
  text += "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  return text;
}

void write_vtu(const std::filesystem::path& path, std::span<const Node> nodes, std::span<const Tet> tets,
               std::span<const PointField> fields) {
  write_file_content(path, format_vtu(nodes, tets, fields));
}

}  // namespace tissued::protocol
