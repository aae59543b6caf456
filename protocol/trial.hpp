#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/file_error.hpp"

namespace tissued::protocol {

/// A recording whose content is refused. line() is 0 for binary files; the reason then names the byte.
class TrialError : public FileError {
 public:
  using FileError::FileError;
};

/// One recorded trial: trajectories and device forces at one rate, whatever file they came from. Which labels are
/// markers, targets or pads is for the caller to say.
struct Trial {
  std::string file;      ///< for messages
  double rate_hz = 0.0;  ///< frames per second
  int first_frame = 1;   ///< the recording's own number of frame 0
  std::size_t frame_count = 0;

  std::vector<std::string> labels;               ///< (l) without their subject
  std::vector<std::string> subjects;             ///< (l) `phantom` of `phantom:M01`; empty where there is none
  std::vector<std::array<double, 3>> positions;  ///< (frame_count * l x 3) mm, tracker frame; finite, NaN in gaps
  std::vector<std::uint8_t> seen;                ///< (frame_count * l) 0 in gaps

  std::vector<std::string> devices;           ///< (d) `A1` of the device `A1 - Force`
  std::vector<std::array<double, 3>> forces;  ///< (frame_count * d x 3) N; NaN where the cell was empty

  const std::array<double, 3>& position(std::size_t frame, std::size_t label) const {
    return positions[frame * labels.size() + label];
  }
  bool is_seen(std::size_t frame, std::size_t label) const { return seen[frame * labels.size() + label] != 0; }
  const std::array<double, 3>& force(std::size_t frame, std::size_t device) const {
    return forces[frame * devices.size() + device];
  }

  /// Index of a trajectory by its label, or by `subject:label` where two subjects share a label.
  std::optional<std::size_t> find_label(std::string_view name) const;
  /// Index of a device by its name.
  std::optional<std::size_t> find_device(std::string_view name) const;

  /// `subject:label`, or the label alone where there is no subject.
  std::string full_label(std::size_t label) const;
  /// Splits `subject:label` at the first colon and appends both parts; without a subject it is all label.
  void add_label(std::string_view full);
};

/// 1 for `mm`, 10 for `cm`, 1000 for `m`; nothing for a unit that recordings are not read in.
std::optional<double> millimetres_per(std::string_view unit);

}  // namespace tissued::protocol
