// Any bytes as a TetGen set, its files parted by zeros (.node, .ele and perhaps .face): a sound mesh or a MeshError.

#include <cstdint>
#include <optional>
#include <string_view>

#include "protocol/tetgen_file.hpp"
#include "tests/fuzz/mesh_promises.hpp"

using namespace tissued::protocol;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  const auto next_file = [&] {
    const std::string_view text = rest.substr(0, rest.find('\0'));
    rest.remove_prefix(text.size() < rest.size() ? text.size() + 1 : rest.size());
    return text;
  };
  const TetgenText node{"fuzz.node", next_file()};
  const TetgenText ele{"fuzz.ele", next_file()};
  const auto face = rest.empty() ? std::nullopt : std::optional(TetgenText{"fuzz.face", next_file()});
  try {
    tissued::fuzz::check_mesh(parse_tetgen(node, ele, face));
  } catch (const MeshError& error) {
    tissued::fuzz::promise(error.line() >= 0, "an error has a line or none");
  }
  return 0;
}
