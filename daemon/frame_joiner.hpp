#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "config/daemon_config.hpp"
#include "protocol/frame_assembler.hpp"
#include "protocol/vicon_stream.hpp"

namespace tissued::daemon {

/// From the tracker's datagrams to frames, names without the bundle's subject: what tissued does with them as they
/// come, and what is done with a recording of them. The same calls give the same frames. Nothing allocates after
/// construction.
class FrameJoiner {
 public:
  explicit FrameJoiner(const config::DaemonConfig& config);

  /// The frames that the datagram finished, see protocol::FrameAssembler::add; none where it was refused.
  std::span<const protocol::TrackerFrame> add(std::span<const std::uint8_t> bytes, std::uint64_t receive_ns);
  std::span<const protocol::TrackerFrame> flush_if_due(std::uint64_t now_ns) { return assembler_.flush_if_due(now_ns); }
  std::optional<std::uint64_t> due_ns() const { return assembler_.due_ns(); }

  /// Of the datagram that was added last.
  protocol::TrackerRefusal refusal() const { return refusal_; }
  int skipped_items() const;
  std::uint64_t count(protocol::AssemblerEvent event) const { return assembler_.count(event); }

 private:
  void strip_subject(protocol::Name& name) const;

  protocol::FrameAssembler assembler_;
  protocol::TrackerDatagram datagram_;
  protocol::TrackerRefusal refusal_ = protocol::TrackerRefusal::none;
  std::string subject_prefix_;  // `phantom:`; empty where there is no subject
};

}  // namespace tissued::daemon
