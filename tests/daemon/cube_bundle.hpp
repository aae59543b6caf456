#pragma once

#include <filesystem>
#include <string>

#include "tests/temporary_folder.hpp"

// A bundle that the real simulators can be built from: a cube of 40 mm in six tetrahedra, held at z = 0, a pad at
// x = 40 mm.
inline std::string cube_mesh() {
  return R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
2 1 "base"
2 2 "skin"
2 3 "A1"
3 4 "tissue"
$EndPhysicalNames
$Nodes
8
1 0 0 0
2 40 0 0
3 40 40 0
4 0 40 0
5 0 0 40
6 40 0 40
7 40 40 40
8 0 40 40
$EndNodes
$Elements
18
1 2 2 1 1 1 2 3
2 2 2 1 1 1 3 4
3 2 2 3 2 2 3 7
4 2 2 3 2 2 7 6
5 2 2 2 3 4 8 7
6 2 2 2 3 4 7 3
7 2 2 2 4 5 6 7
8 2 2 2 4 5 7 8
9 2 2 2 5 1 5 8
10 2 2 2 5 1 8 4
11 2 2 2 6 1 2 6
12 2 2 2 6 1 6 5
13 4 2 4 7 1 2 3 7
14 4 2 4 7 1 4 8 7
15 4 2 4 7 1 5 6 7
16 4 2 4 7 1 6 2 7
17 4 2 4 7 1 3 4 7
18 4 2 4 7 1 8 5 7
$EndElements
)";
}

inline std::string cube_description() {
  return R"({
  "format": "tissue-recording/1",
  "name": "cube",
  "units": {"length": "mm", "time": "s", "stress": "kPa", "force": "N", "density": "g/cm3", "gravity": "g0"},
  "mesh": "mesh.msh",
  "fixed": "base",
  "surface": "skin",
  "material": {"model": "neo-hookean", "youngs_modulus": 6.0, "poissons_ratio": 0.45, "density": 1.0},
  "gravity": [0, 0, 0],
  "rate": 100.0,
  "actuators": {"A1": {"surface": "A1", "center": [40, 20, 20], "normal": [1, 0, 0], "direction": [-1, 0, 0],
                       "radius": 20.0, "attachment": "glued"}},
  "markers": {"M1": [20, 20, 40], "M2": [10, 30, 40], "M3": [30, 30, 40], "M4": [0, 20, 30]},
  "targets": {"T1": [20, 20, 25]},
  "noise": {"marker": 0.1}
})";
}

inline std::filesystem::path write_cube_bundle(const TemporaryFolder& folder) {
  folder.write("mesh.msh", cube_mesh());
  folder.write("bundle.json", cube_description());
  return folder.path();
}
