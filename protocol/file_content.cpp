#include "protocol/file_content.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "protocol/file_error.hpp"

namespace tissued::protocol {

std::string read_file_content(const std::filesystem::path& path) {
  // An ifstream opens a folder without complaint and fails only later, with nothing to say.
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw FileError(path.string(), 0, "is a folder, not a file");
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw FileError(path.string(), 0, std::string("cannot be opened: ") + std::strerror(errno));
  // Piece by piece, not by the size stated beforehand, which pipes and /proc do not know.
  std::string content;
  std::array<char, 65536> piece{};
  do {
    stream.read(piece.data(), piece.size());
    content.append(piece.data(), static_cast<std::size_t>(stream.gcount()));
  } while (stream);
  if (stream.bad()) throw FileError(path.string(), 0, std::string("cannot be read: ") + std::strerror(errno));
  return content;
}

void write_file_content(const std::filesystem::path& path, std::string_view content) {
  errno = 0;
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  if (!stream) throw FileError(path.string(), 0, std::string("cannot be created: ") + std::strerror(errno));
  stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  stream.close();
  if (!stream) throw FileError(path.string(), 0, std::string("cannot be written: ") + std::strerror(errno));
}

}  // namespace tissued::protocol
