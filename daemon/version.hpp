#pragma once

namespace tissued::daemon {

/// Of this build, as in the top CMakeLists.txt.
inline constexpr const char* kVersion = TISSUED_VERSION;

}  // namespace tissued::daemon
