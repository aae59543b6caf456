#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace tissued::protocol {

/// All bytes of a file. Throws FileError where it cannot be read.
std::string read_file_content(const std::filesystem::path& path);

/// Writes `content` as the whole of a file. Throws FileError where it cannot be written to the end.
void write_file_content(const std::filesystem::path& path, std::string_view content);

}  // namespace tissued::protocol
