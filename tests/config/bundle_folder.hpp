// A bundle on disk for one test, gone afterwards.
#pragma once

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "config/config_error.hpp"
#include "config/json_reader.hpp"
#include "tests/temporary_folder.hpp"

namespace tissued::config {

// Uses every key of the format once.
inline const char* const kFullBundle = R"({
  "format": "tissue-recording/1", "name": "block",
  "units": {"length": "mm", "time": "s", "stress": "kPa", "force": "N", "density": "g/cm3", "gravity": "g0"},
  "mesh": "block.msh", "fixed": "base", "surface": "skin",
  "material": {"model": "neo-hookean", "youngs_modulus": 6.5, "poissons_ratio": 0.45, "density": 1.02},
  "gravity": [0, 0, -1], "subject": "phantom", "rate": 50, "dynamic": true,
  "world_from_tracker": {"rotation": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "translation": [10, 20, 30], "note": "axes"},
  "actuators": {
    "A2": {"surface": "A2", "center": [1, 2, 3], "normal": [0, 0, 1], "direction": [0, 0, -1], "radius": 15,
           "attachment": "glued"},
    "A1": {"surface": "A1", "center": [4, 5, 6], "normal": [0, 1, 0], "direction": [0, -1, 0], "radius": 12,
           "attachment": "glued"}
  },
  "probes": {
    "US": {"shape": {"center": [0, 1, -30], "half_extents": [20, 8, 30], "rounding": 3}, "friction": 0.1,
           "image": {"probe_T_image": {"rotation": [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "translation": [-19, 0.5, 2]},
                     "spacing": [0.1, 0.125], "size": [380, 512]}},
    "bare": {"shape": {"half_extents": [5, 5, 10]}}
  },
  "markers": {"M10": [1, 0, 0], "M2": [2, 0, 0], "M1": [3, 0, 0]},
  "marker_sets": {"few": ["M1", "M10"]}, "marker_note": "on stalks",
  "targets": {"T10": [0, 1, 0], "T9": [0, 2, 0]},
  "noise": {"marker": 0.1, "target": 0.3, "force": 0.01},
  "trials": ["push", "fall"], "held_out": ["last"],
  "trial": {"fall": {"file": "fall.c3d", "held_until_frame": 66, "end_frame": 500, "start": "straight",
    "loads": [{"edge": [[0, 0, 30], [0, 30, 30]], "force": [0, 0, -0.5], "mass": 52}]}}
})";

class BundleFolder : public TemporaryFolder {
 public:
  explicit BundleFolder(const std::string& bundle = kFullBundle) {
    write("bundle.json", bundle);
    write("block.msh", "");
  }
};

// The document with the value at `key` replaced, or taken out where `value` is "".
inline std::string with(const std::string& document, const std::string& key, const std::string& value) {
  Json root = Json::parse(document);
  const JsonPointer pointer(key);
  if (value.empty()) {
    root[pointer.parent_pointer()].erase(pointer.back());
  } else {
    root[pointer] = Json::parse(value);
  }
  return root.dump();
}

// What the ConfigError that `action` throws says; the test fails where it throws none.
inline std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const ConfigError& error) {
    return error.what();
  }
  FAIL("nothing was refused");
  return "";
}

}  // namespace tissued::config
