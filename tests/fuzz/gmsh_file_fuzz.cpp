// Any bytes as a Gmsh file: a sound mesh or a MeshError.

#include <cstdint>
#include <string_view>

#include "protocol/gmsh_file.hpp"
#include "tests/fuzz/mesh_promises.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    tissued::fuzz::check_mesh(tissued::protocol::parse_gmsh(text, "fuzz.msh"));
  } catch (const tissued::protocol::MeshError& error) {
    tissued::fuzz::promise(error.line() >= 0, "an error has a line or none");
  }
  return 0;
}
