// Writes the seeds of the file fuzzers: FOLDER/TARGET/*.

#include <filesystem>
#include <string>
#include <vector>

#include "protocol/file_content.hpp"
#include "tests/protocol/c3d_bytes.hpp"
#include "tests/protocol/hand_export.hpp"
#include "tests/protocol/hand_meshes.hpp"

using namespace tissued::tests;

namespace {

void write(const std::filesystem::path& folder, const std::vector<std::string>& seeds) {
  std::filesystem::create_directories(folder);
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    tissued::protocol::write_file_content(folder / std::to_string(i), seeds[i]);
  }
}

std::string integer_c3d() {
  C3dFile file(Machine::mips);
  file.points = 1;
  file.scale = 0.5F;
  file.usual_parameters({"one"}, "m");
  file.integer_point(1, 2, 3, 0);
  return file.content();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  const std::string zero(1, '\0');
  write(folder / "gmsh_file", {kGmsh2, kGmsh4});
  write(folder / "tetgen_file", {kTetgenNode + zero + kTetgenEle + zero + kTetgenFace});
  write(folder / "nexus_csv", {kExport});
  write(folder / "c3d",
        {small_c3d_file(Machine::intel).content(), small_c3d_file(Machine::dec).content(), integer_c3d()});
  write(folder / "config",
        {R"({"format": "tissued-config/1", "bundle": "demo", "tracker": {"port": 51001, "frame_deadline_ms": null},
             "simulator": {"kind": "kf-admm", "iterations": 10}, "gravity": [0, 0, -9810], "markers": ["M1"]})",
         tissued::protocol::read_file_content(TISSUED_DEMO_BUNDLE)});
  const std::string digits = "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f";
  write(folder / "key_file", {"# who may speak\nvicon tracker " + digits + "\n", "a both " + digits});
  return 0;
}
