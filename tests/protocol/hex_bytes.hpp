#pragma once

#include <cstdint>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace tissued::protocol {

// "01 ff" -> {0x01, 0xff}; whitespace between the bytes as it likes.
inline std::vector<std::uint8_t> bytes_of_hex(const std::string& text) {
  std::istringstream words(text);
  std::vector<std::uint8_t> bytes;
  for (std::string word; words >> word;) bytes.push_back(static_cast<std::uint8_t>(std::stoul(word, nullptr, 16)));
  return bytes;
}

// The bytes of the block "```hex LABEL" of protocol/README.md.
inline std::vector<std::uint8_t> bytes_of_readme(const std::string& label) {
  std::ifstream readme(std::string(TISSUED_SOURCE_DIR) + "/protocol/README.md");
  std::string line;
  while (std::getline(readme, line)) {
    if (line != "```hex " + label) continue;
    std::string block;
    while (std::getline(readme, line) && line != "```") block += line + '\n';
    return bytes_of_hex(block);
  }
  throw std::runtime_error("protocol/README.md has no block ```hex " + label);
}

}  // namespace tissued::protocol
