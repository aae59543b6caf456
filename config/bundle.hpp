// A bundle: the folder that somebody at the tracking system has in hand after a session.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/config_error.hpp"
#include "core/image_plane.hpp"
#include "core/rest_calibration.hpp"
#include "core/scene.hpp"

namespace tissued::config {

// A named subset of the markers, where a study compares them.
struct MarkerSet {
  std::string name;
  std::vector<std::string> markers;
};

// Standard deviations per axis that the makers of the devices state; 0 where nothing is stated.
struct DeviceNoise {
  double marker = 0.1;  // mm
  double target = 0.0;  // mm
  double force = 0.0;   // N
};

// What a bundle knows of a pad beyond core::Pad.
struct PadShape {
  core::Vec3 normal;    // unit, tissue, outwards
  double radius = 0.0;  // mm
};

struct TrialInfo {
  std::string name;
  std::filesystem::path file;         // of the recording, with the bundle's folder; whether it exists was not asked
  bool held_out = false;              // never fitted: for showing that an explanation predicts
  int held_until_frame = 0;           // from 0; the body is held at rest before it and free after
  std::optional<int> end_frame;       // from 0, exclusive; none: to the end of the file
  std::string start;                  // shape at the start, e.g. "straight"; empty where nothing is said
  std::vector<core::EdgeLoad> loads;  // while the body is free
};

struct Bundle {
  std::filesystem::path folder;
  std::filesystem::path mesh_file;   // with the folder; it exists
  core::Scene scene;                 // all markers of the bundle; `mesh` is empty: who reads mesh_file joins it
  std::vector<PadShape> pad_shapes;  // (scene.pads)
  std::vector<std::optional<core::ImagePlane>> probe_images;  // (scene.probes); none: the probe's image is not known
  std::vector<MarkerSet> marker_sets;
  DeviceNoise noise;              // noise.marker is scene.marker_noise, too
  std::string subject;            // `phantom` of the labels `phantom:M01`; may be empty
  bool dynamic = false;           // inertia matters: the body swings
  std::vector<TrialInfo> trials;  // in the file's order, held-out ones last

  // Where the bundle says how the tracker's axes lie (world_from_tracker); identity, and not given, where it does not.
  bool has_tracker_pose = false;
  core::RigidTransform tissue_from_tracker;

  // nullptr where there is none of that name.
  const TrialInfo* find_trial(const std::string& name) const;
  const MarkerSet* find_marker_set(const std::string& name) const;
};

// Reads FOLDER/bundle.json ("tissue-recording/1"; config/schema/bundle.schema.json describes every key).
// overrides: `material.poissons_ratio=0.42`, `gravity=[0,0,-1]`, ...: keys of bundle.json with dots between, and the
// value as JSON (text that is not JSON is taken as a string). They pass the same checks as the file.
// Throws ConfigError.
Bundle load_bundle(const std::filesystem::path& folder, std::span<const std::string> overrides = {});

}  // namespace tissued::config
