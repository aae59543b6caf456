#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "config/bundle.hpp"
#include "protocol/tracker_frame.hpp"
#include "protocol/trial.hpp"

namespace tissued::daemon {

/// Reads a trial's file by its extension: `.csv` (Nexus) or `.c3d`. Throws protocol::FileError.
protocol::Trial read_trial(const std::filesystem::path& path);

/// The trajectory of a marker, target or pad of the bundle: by the bundle's subject and the name, else by the name
/// alone.
std::optional<std::size_t> find_label(const config::Bundle& bundle, const protocol::Trial& trial,
                                      const std::string& name);

/// What of a recording is put into tracker frames.
struct RecordingItems {
  const config::MarkerSet* marker_set = nullptr;  ///< nullptr: all markers of the bundle
  bool pad_forces = false;                        ///< device forces as force items
  bool truth = true;                              ///< recorded targets as truth items
};

/// How far a recorded pad was pushed.
struct PadPush {
  std::size_t pad;    ///< in the bundle's scene
  double largest_mm;  ///< distance from its rest pose
};

/// One trial, read as its bundle says: which label is a marker, a pad or a target.
class Recording {
 public:
  /// The bundle must outlive the recording. Throws std::runtime_error where the trial holds nothing that the bundle
  /// knows.
  Recording(const config::Bundle& bundle, const config::TrialInfo& info, protocol::Trial trial);

  const std::string& name() const { return info_.name; }
  double rate_hz() const { return trial_.rate_hz; }
  std::size_t frame_count() const { return trial_.frame_count; }
  int first_frame() const { return trial_.first_frame; }  ///< the recording's own number of frame 0

  /// Fills the item lists of `frame` with what was recorded at `index`; a marker gap goes out as occluded, a pad gap or
  /// an unknown force not at all. Number and stamp are the caller's. False where an item is beyond what a frame holds.
  bool fill(std::size_t index, const RecordingItems& items, protocol::TrackerFrame& frame) const;

  /// mm, tracker; where the recording has target `target` of the bundle's scene at `index`.
  std::optional<core::Vec3> target(std::size_t index, std::size_t target) const;

  /// One for every recorded pad, in the scene's order.
  const std::vector<PadPush>& pushes() const { return pushes_; }

  /// Frames of the hold: every recorded pad within 1e-3 mm of its largest displacement. The first 20 % of them, in
  /// which the tissue may still be settling, are left out. Empty without pads that move.
  const std::vector<std::size_t>& hold() const { return hold_; }

  /// How many frames the recording begins with in which the body is held and no pad is further than 0.2 mm from its
  /// pose at frame 0; at least 1.
  std::size_t opening_rest() const { return opening_rest_; }

 private:
  struct Column {
    std::size_t source;  // index of the label or device in the trial
    std::size_t entry;   // index of the marker, pad or target in the bundle's scene
    protocol::Name name;
  };
  core::Vec3 position(std::size_t index, std::size_t label) const;
  void find_columns();
  void find_hold();
  void find_opening_rest();

  const config::Bundle& bundle_;
  config::TrialInfo info_;
  protocol::Trial trial_;
  std::vector<Column> markers_, pads_, targets_, forces_;
  std::vector<PadPush> pushes_;
  std::vector<std::size_t> hold_;
  std::size_t opening_rest_ = 1;
};

}  // namespace tissued::daemon
