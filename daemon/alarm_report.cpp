#include "daemon/alarm_report.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace tissued::daemon {

using nlohmann::json;

std::string alarm_text(const protocol::AlarmState& alarm) {
  char text[160];
  if (!alarm.watching && !alarm.raised) return "not watching yet";
  std::snprintf(text, sizeof text, "level %.2f, %.2f mm unexplained", alarm.level, alarm.misfit);
  std::string line = text;
  const auto& p = alarm.place;
  if (alarm.raised && alarm.has_place) {
    std::snprintf(text, sizeof text, " around (%.0f, %.0f, %.0f) mm", p[0], p[1], p[2]);
    line += text;
  }
  if (alarm.raised) line += ", since frame " + std::to_string(alarm.since_frame);
  return (alarm.raised ? "raised, " : "") + line;
}

json alarm_json(const protocol::AlarmState& alarm) {
  return {{"watching", alarm.watching},
          {"raised", alarm.raised},
          {"level", alarm.level},
          {"misfit_mm", alarm.misfit},
          {"place_mm", alarm.has_place ? json(alarm.place) : json()},
          {"since_frame", alarm.raised ? json(alarm.since_frame) : json()},
          {"since_ns", alarm.raised ? json(alarm.since_ns) : json()}};
}

}  // namespace tissued::daemon
