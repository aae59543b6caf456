#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/csv_reader.hpp"
#include "protocol/trial.hpp"

namespace tissued::protocol {

/// What the name of a device that measures a force ends with.
inline constexpr std::string_view kNexusForceSuffix = " - Force";

/// The two blocks of a Nexus export that are read.
enum class NexusBlockKind { trajectories, devices };

/// One block: three neighbouring columns a name, one value a frame.
///
///     Trajectories
///     100
///     ,,phantom:M01,,,phantom:M02,,
///     Frame,Sub Frame,X,Y,Z,X,Y,Z
///     ,,mm,mm,mm,mm,mm,mm
///     1,0,-0.116,0.029,60.078,,,
struct NexusBlock {
  double rate_hz = 0.0;
  std::vector<std::string> names;             ///< (k) as in the file
  std::vector<std::array<double, 3>> values;  ///< (frame_count * k x 3) mm or N; NaN where the cells are empty
  std::int64_t first_frame = 0;
  std::size_t frame_count = 0;
  int sub_frames = 0;  ///< rows per frame; the values are those of sub frame 0
  int last_line = 0;   ///< of the last row

  std::int64_t last_frame() const { return first_frame + static_cast<std::int64_t>(frame_count) - 1; }
};

/// Reads the block whose title is the reader's current line, up to the blank line that ends it. Devices other than
/// `NAME - Force` are passed over. Throws TrialError; `file` is for messages.
NexusBlock read_nexus_block(CsvReader& reader, const std::string& file, NexusBlockKind kind);

}  // namespace tissued::protocol
