#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace tissued::protocol {

/// Values at the nodes of a mesh, such as displacement in mm; a view, owned by the caller.
struct PointField {
  std::string name;
  int components = 1;              ///< per node
  std::span<const double> values;  ///< (n x components), node by node
};

/// Writes a tetrahedral mesh as VTK XML unstructured grid (.vtu), ASCII, numbers in the fewest digits that read back to
/// the same bits. `nodes` (n x 3) mm; `tets` (t x 4) node indices from 0.
/// Throws FileError where the file cannot be written, std::invalid_argument where a field's size does not fit the
/// nodes, an index is out of range or a number is not finite (VTK's ASCII has no word for it).
void write_vtu(const std::filesystem::path& path, std::span<const std::array<double, 3>> nodes,
               std::span<const std::array<std::int32_t, 4>> tets, std::span<const PointField> fields);

/// The text that write_vtu writes.
std::string format_vtu(std::span<const std::array<double, 3>> nodes, std::span<const std::array<std::int32_t, 4>> tets,
                       std::span<const PointField> fields);

}  // namespace tissued::protocol
