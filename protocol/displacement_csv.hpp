#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/file_error.hpp"

namespace tissued::protocol {

/// The displacement of every node of a mesh; rows in any order, so match them by position.
struct DisplacementTable {
  std::vector<std::array<double, 3>> rest;          ///< (n x 3) mm
  std::vector<std::array<double, 3>> displacement;  ///< (n x 3) mm
};

/// Reads a table with the header `x,y,z,ux,uy,uz`. Throws FileError, which names line, column and reason.
DisplacementTable read_displacement_csv(const std::filesystem::path& path);

/// The same from memory; `name` is for messages.
DisplacementTable parse_displacement_csv(std::string_view text, const std::string& name);

/// Writes such a table, numbers in the fewest digits that read back to the same bits. Throws FileError where the file
/// cannot be written, std::invalid_argument where the columns differ in length.
void write_displacement_csv(const DisplacementTable& table, const std::filesystem::path& path);

/// The text that write_displacement_csv writes.
std::string format_displacement_csv(const DisplacementTable& table);

}  // namespace tissued::protocol
