#pragma once

#include <filesystem>

#include "config/bundle.hpp"
#include "core/diagnosis/session.hpp"

namespace tissued::daemon {

/// All trials of a bundle as core::diagnosis sees them, in tissue coordinates. A pad that a trial does not have is off
/// the skin; one that was not seen for a while stays where it was last seen. Throws protocol::FileError, MeshError or
/// std::runtime_error, which name the file.
core::RecordedSession load_session(const config::Bundle& bundle);

}  // namespace tissued::daemon
