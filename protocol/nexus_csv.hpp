#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "protocol/trial.hpp"

namespace tissued::protocol {

/// Reads a Nexus-style ASCII export: a `Trajectories` block (X, Y, Z in mm, cm or m; an empty cell is a gap) and,
/// where there is one, a `Devices` block, of which the three components in N of every device `NAME - Force` are read
/// and all else is passed over, as are blocks of other names.
///
/// Devices may sample a whole number of times faster than the trajectories: the sample of sub frame 0, which is of the
/// trajectories' instant, is taken. Both blocks must hold the same frames, numbered without a hole.
/// Throws TrialError, which names line, column and reason, for content; FileError where the file cannot be read.
Trial read_nexus_csv(const std::filesystem::path& path);

/// The same from memory; `name` is for messages.
Trial parse_nexus_csv(std::string_view text, const std::string& name);

/// Writes what read_nexus_csv reads: numbers in the fewest digits that read back to the same bits, gaps as empty cells.
/// Throws FileError where the file cannot be written, std::invalid_argument for a name that the format cannot hold.
void write_nexus_csv(const Trial& trial, const std::filesystem::path& path);

/// The text that write_nexus_csv writes.
std::string format_nexus_csv(const Trial& trial);

}  // namespace tissued::protocol
