#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "protocol/alarm_state.hpp"

namespace tissued::daemon {

/// `level 1.20, 0.31 mm unexplained around (12, 3, 20) mm, since frame 4711`; without what is not known or not raised.
std::string alarm_text(const protocol::AlarmState& alarm);
/// For programs; `place_mm`, `since_frame` and `since_ns` are null where there is none.
nlohmann::json alarm_json(const protocol::AlarmState& alarm);

}  // namespace tissued::daemon
