#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace tissued::protocol {

/// All bytes of a file. Throws FileError where it cannot be read.
std::string read_file_content(const std::filesystem::path& path);

/// The same bytes as numbers; `content` must outlive them.
inline std::span<const std::uint8_t> bytes_of(std::string_view content) {
  return {reinterpret_cast<const std::uint8_t*>(content.data()), content.size()};
}

/// Writes `content` as the whole of a file. Throws FileError where it cannot be written to the end.
void write_file_content(const std::filesystem::path& path, std::string_view content);

}  // namespace tissued::protocol
