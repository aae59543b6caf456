#include "daemon/counters.hpp"

namespace tissued::daemon {

namespace {

const char* to_string(Count count) {
  switch (count) {
    case Count::tracker_datagrams:
      return "tracker_datagrams";
    case Count::foreign_datagrams:
      return "foreign_datagrams";
    case Count::kernel_drops:
      return "kernel_drops";
    case Count::unknown_items:
      return "unknown_items";
    case Count::frames_stepped:
      return "frames_stepped";
    case Count::frames_skipped:
      return "frames_skipped";
    case Count::unknown_names:
      return "unknown_names";
    case Count::delayed_markers:
      return "delayed_markers";
    case Count::markers_too_late:
      return "markers_too_late";
    case Count::late_markers:
      return "late_markers";
    case Count::pads_held:
      return "pads_held";
    case Count::stamps_refused:
      return "stamps_refused";
    case Count::dt_clamped:
      return "dt_clamped";
    case Count::rate_changes:
      return "rate_changes";
    case Count::rate_changes_failed:
      return "rate_changes_failed";
    case Count::steps_not_finite:
      return "steps_not_finite";
    case Count::steps_braked:
      return "steps_braked";
    case Count::answers_unseen:
      return "answers_unseen";
    case Count::client_datagrams:
      return "client_datagrams";
    case Count::challenges_sent:
      return "challenges_sent";
    case Count::requests_unproven:
      return "requests_unproven";
    case Count::requests_limited:
      return "requests_limited";
    case Count::requests_repeated:
      return "requests_repeated";
    case Count::clients_refused:
      return "clients_refused";
    case Count::leases_expired:
      return "leases_expired";
    case Count::datagrams_sent:
      return "datagrams_sent";
    case Count::sends_failed:
      return "sends_failed";
    case Count::transfers_refused:
      return "transfers_refused";
    case Count::records_written:
      return "records_written";
    case Count::records_lost:
      return "records_lost";
    case Count::recording_failed:
      return "recording_failed";
    case Count::rest_frames:
      return "rest_frames";
    case Count::registration_rms_um:
      return "registration_rms_um";
  }
  return "unknown";
}

// Of a gate, or of what passed all gates.
template <typename Refusal>
std::string gate_name(const char* gates, std::size_t place) {
  const auto refusal = static_cast<Refusal>(place);
  return std::string(gates).append(refusal == Refusal::none ? "accepted" : protocol::to_string(refusal));
}

}  // namespace

std::string Counters::name(std::size_t index) {
  using protocol::AssemblerEvent;
  using protocol::ClientRefusal;
  using protocol::TrackerRefusal;
  if (index < kFirstEvent) return to_string(static_cast<Count>(index));
  if (index < kFirstTrackerRefusal) return protocol::to_string(static_cast<AssemblerEvent>(index - kFirstEvent));
  if (index < kFirstClientRefusal) return gate_name<TrackerRefusal>("tracker:", index - kFirstTrackerRefusal);
  if (index < kFirstSealRefusal) return gate_name<ClientRefusal>("client:", index - kFirstClientRefusal);
  return gate_name<protocol::SealRefusal>("seal:", index - kFirstSealRefusal);
}

}  // namespace tissued::daemon
