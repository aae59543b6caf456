#pragma once

namespace tissued::daemon {

/// body_view.js, as it was when the program was built: draws what body_view() hands to it.
extern const char* const kBodyViewScript;

}  // namespace tissued::daemon
