#pragma once

namespace tissued::daemon {

/// From its construction on SIGINT and SIGTERM no longer kill the process but are remembered, so that a command can end
/// with its summary; a second one kills. At most one at a time.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  bool requested() const noexcept;
};

}  // namespace tissued::daemon
