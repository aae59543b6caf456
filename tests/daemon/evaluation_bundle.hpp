// The cube as a bundle with two recorded trials, for evaluations.
#pragma once

#include <cmath>
#include <random>

#include "protocol/nexus_csv.hpp"
#include "tests/daemon/cube_bundle.hpp"

inline constexpr std::size_t kCubeFrames = 70;

// 100 Hz; frames 0 to 4 at rest, 5 to 24 the pad moving in by `push` mm, 25 to 59 held, then out. Markers and target
// follow by half as much, with noise; M2 is not seen in frames 30 to 39, T1 not in frame 45.
inline tissued::protocol::Trial cube_trial(double push, unsigned seed) {
  tissued::protocol::Trial trial;
  trial.rate_hz = 100;
  trial.frame_count = kCubeFrames;
  trial.labels = {"M1", "M2", "M3", "M4", "T1", "A1"};
  trial.subjects.assign(6, "");
  const double rest[6][3] = {{20, 20, 40}, {10, 30, 40}, {30, 30, 40}, {0, 20, 30}, {20, 20, 25}, {40, 20, 20}};
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 0.1);
  for (std::size_t frame = 0; frame < kCubeFrames; ++frame) {
    const double i = static_cast<double>(frame);
    const double in = push * (frame < 5 ? 0.0 : frame < 25 ? (i - 4.0) / 20.0 : frame < 60 ? 1.0 : (69.0 - i) / 10.0);
    for (std::size_t label = 0; label < 6; ++label) {
      const bool hidden = (label == 1 && frame >= 30 && frame < 40) || (label == 4 && frame == 45);
      trial.seen.push_back(hidden ? 0 : 1);
      const double share = label == 5 ? 1.0 : 0.5;
      std::array<double, 3> position{rest[label][0] - share * in, rest[label][1], rest[label][2]};
      if (label != 5) {
        for (double& p : position) p += noise(random);
      }
      if (hidden) position.fill(std::nan(""));
      trial.positions.push_back(position);
    }
  }
  return trial;
}

// With marker sets `most` (three markers) and `few` (two), trials `shallow` (2 mm) and `deep` (5 mm).
inline std::filesystem::path write_evaluation_bundle(const TemporaryFolder& folder, const std::string& name = "cube") {
  folder.write("mesh.msh", cube_mesh());
  std::string description = cube_description();
  const std::string noise = R"("noise": {"marker": 0.1})";
  description.replace(description.find(noise), noise.size(), R"("noise": {"marker": 0.1, "target": 0.2},
  "marker_sets": {"most": ["M1", "M2", "M3"], "few": ["M1", "M3"]},
  "trials": ["shallow", "deep"])");
  description.replace(description.find("\"cube\""), 6, '"' + name + '"');
  folder.write("bundle.json", description);
  tissued::protocol::write_nexus_csv(cube_trial(2.0, 1), folder.path() / "shallow.csv");
  tissued::protocol::write_nexus_csv(cube_trial(5.0, 2), folder.path() / "deep.csv");
  return folder.path();
}
