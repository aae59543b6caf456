#include "protocol/tracker_frame.hpp"

namespace tissued::protocol {

const char* to_string(FrameCompletion completion) {
  switch (completion) {
    case FrameCompletion::all_parts:
      return "all_parts";
    case FrameCompletion::all_names:
      return "all_names";
    case FrameCompletion::superseded:
      return "superseded";
    case FrameCompletion::deadline:
      return "deadline";
  }
  return "unknown";
}

}  // namespace tissued::protocol
