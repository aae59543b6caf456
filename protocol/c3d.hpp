#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "protocol/trial.hpp"

namespace tissued::protocol {

/// Reads the points of a C3D file: Intel, DEC or MIPS numbers, float or scaled integer points. POINT:UNITS (mm, cm, m;
/// mm where absent) are converted to mm. A point whose fourth word is negative, or that is not finite, is a gap. Analog
/// samples are stepped over; `devices` stays empty.
///
/// Takes above 65535 frames are counted by TRIAL:ACTUAL_START_FIELD and ACTUAL_END_FIELD or POINT:LONG_FRAMES; labels
/// beyond 255 come from POINT:LABELS2 and on. A point without a label is called `point N`, N from 1.
/// Throws TrialError, which names the byte where one is to blame; FileError where the file cannot be read.
Trial read_c3d(const std::filesystem::path& path);

/// The same from memory; `name` is for messages.
Trial parse_c3d(std::span<const std::byte> bytes, const std::string& name);

/// Writes the trajectories as C3D: Intel, float points, mm. Positions are rounded to float; device forces are not
/// written. Throws FileError where the file cannot be written, std::invalid_argument for what C3D cannot hold (more
/// than 65535 points, a name longer than 127 bytes).
void write_c3d(const Trial& trial, const std::filesystem::path& path);

/// The bytes that write_c3d writes.
std::string format_c3d(const Trial& trial);

}  // namespace tissued::protocol
