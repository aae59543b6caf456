#include "daemon/prediction_client.hpp"

#include <algorithm>
#include <random>

#include "daemon/monotonic_clock.hpp"
#include "daemon/piecewise_table.hpp"

namespace tissued::daemon {
namespace {

using namespace protocol;

std::uint64_t ns(std::chrono::milliseconds duration) {
  return static_cast<std::uint64_t>(std::chrono::nanoseconds(duration).count());
}

}  // namespace

PredictionClient::PredictionClient(const Endpoint& daemon, const std::optional<SecretKey>& key, Patience patience)
    : daemon_(daemon),
      patience_(patience),
      socket_(daemon, SealChannel::client, key),
      session_(std::random_device{}()) {}

std::optional<ReceivedMessage> PredictionClient::receive(std::uint64_t deadline_ns) {
  while (const auto datagram = socket_.receive(deadline_ns)) {
    const std::uint64_t now = monotonic_ns();
    DecodedMessage decoded = decode_client_message(*datagram);
    if (decoded.refusal != ClientRefusal::none) {
      ++refused_;
      continue;
    }
    if (speaks_of_address(decoded.message)) continue;
    const SequenceVerdict verdict = gate_.judge(decoded.header.envelope);
    if (verdict == SequenceVerdict::duplicate) {
      ++duplicates_;
      continue;
    }
    return ReceivedMessage{decoded.header.envelope, decoded.message, now, verdict};
  }
  return std::nullopt;
}

// What the daemon says of where we send from, before we have a place among its clients; its numbers count nothing yet.
bool PredictionClient::speaks_of_address(const ClientMessage& message) {
  if (const auto* proof = std::get_if<AddressProof>(&message)) {
    address_proven_ = proof->cookie == CookieBytes{};
    if (!address_proven_) send_one(ProveAddress{proof->cookie});
    return true;
  }
  const auto* error = std::get_if<Error>(&message);
  const bool unproven = error != nullptr && error->reason == ErrorReason::address_unproven;
  if (unproven && address_proven_) {
    address_proven_ = false;
    send_one(ProveAddress{});
  }
  return unproven;
}

void PredictionClient::throw_if_refused(const ReceivedMessage& received) const {
  const Error* error = std::get_if<Error>(&received.message);
  if (error == nullptr) return;
  const std::string detail =
      error->refusal == ClientRefusal::none ? "" : std::string(" (") + to_string(error->refusal) + ")";
  throw RequestRefused(to_string(daemon_) + " refuses: " + to_string(error->reason) + detail);
}

template <typename Message>
void PredictionClient::ask(const Message& request, const std::function<bool(const ReceivedMessage&)>& take) {
  const std::uint32_t first = sequence_ + 1;
  bool answered = false;
  for (int attempt = 0; attempt < patience_.attempts; ++attempt) {
    if (!socket_.meet(monotonic_ns() + ns(patience_.timeout))) continue;
    // A request too short to be answered with an error may have been one too many from an address not proven.
    if (attempt > 0 && !socket_.sealed()) send_one(ProveAddress{});
    send(request);
    std::uint64_t deadline = monotonic_ns() + ns(patience_.timeout);
    // An answer to an earlier attempt is as good: it was only slow.
    while (const auto received = receive(deadline)) {
      if (received->envelope.in_reply_to - first > sequence_ - first) continue;
      throw_if_refused(*received);
      answered = true;
      if (take(*received)) return;
      deadline = monotonic_ns() + ns(patience_.timeout);  // it is coming in pieces: give each its time
    }
  }
  throw NoAnswer(answered ? "the answer of " + to_string(daemon_) + " never came in full: too many datagrams are lost"
                          : "no answer from " + to_string(daemon_) + ": is tissued running there" +
                                (socket_.sealed() ? ", with this key among its own?" : "?"));
}

HelloReply PredictionClient::hello() {
  HelloReply reply;
  ask(Hello{*Name::from("tissuectl")}, [&](const ReceivedMessage& received) {
    const auto* message = std::get_if<HelloReply>(&received.message);
    if (message != nullptr) reply = *message;
    return message != nullptr;
  });
  return reply;
}

std::vector<std::string> PredictionClient::names(NameKind kind) {
  PiecewiseTable<std::string> table;
  ask(QueryNames{kind}, [&](const ReceivedMessage& received) {
    const auto* piece = std::get_if<Names>(&received.message);
    if (piece == nullptr || piece->kind != kind) return false;
    if (!table.resize(piece->total)) return false;
    for (std::size_t i = 0; i < piece->names.size(); ++i) {
      table.put(piece->first + i, std::string(piece->names[i].view()));
    }
    return table.complete();
  });
  return table.take();
}

TargetAnswer PredictionClient::targets() {
  AnswerJoiner joiner;
  std::optional<TargetAnswer> answer;
  ask(QueryTargets{}, [&](const ReceivedMessage& received) {
    const auto* part = std::get_if<Predictions>(&received.message);
    if (part != nullptr) answer = joiner.add(*part, received.receive_ns);
    return answer.has_value();
  });
  return *answer;
}

DaemonStatus PredictionClient::status() {
  const std::vector<std::string> counter_names = names(NameKind::counter);
  DaemonStatus status;
  std::vector<std::uint8_t> parts;  // seen, by index
  ask(QueryStatus{}, [&](const ReceivedMessage& received) {
    const auto* part = std::get_if<Status>(&received.message);
    if (part == nullptr) return false;
    // The parts of one answer have equal scalars but for the send time; of two attempts they may not be mixed.
    if (parts.size() != part->part_count || status.frame.uptime_ns != part->uptime_ns) {
      parts.assign(part->part_count, 0);
      status.counters.clear();
    }
    if (part->part >= parts.size() || parts[part->part] != 0) return false;
    parts[part->part] = 1;
    status.frame = *part;
    for (const Counter& counter : part->counters) {
      const bool named = counter.index < counter_names.size();
      status.counters.emplace_back(named ? counter_names[counter.index] : "unknown", counter.value);
    }
    return std::count(parts.begin(), parts.end(), 0) == 0;
  });
  return status;
}

std::vector<JoinedView> PredictionClient::probes() {
  ViewJoiner joiner;
  std::optional<std::vector<JoinedView>> views;
  ask(QueryProbes{}, [&](const ReceivedMessage& received) {
    const auto* part = std::get_if<ProbeView>(&received.message);
    if (part != nullptr) views = joiner.add(*part);
    return views.has_value();
  });
  return *views;
}

ReceivedMesh PredictionClient::mesh(Precision precision) {
  ReceivedMesh snapshot;
  PiecewiseTable<std::array<double, 3>> table;
  std::uint64_t frame_ns = 0;
  ask(QueryMesh{precision}, [&](const ReceivedMessage& received) {
    const auto* chunk = std::get_if<MeshPositions>(&received.message);
    if (chunk == nullptr) return false;
    if (chunk->tracker_frame != snapshot.tracker_frame || chunk->receive_ns != frame_ns) table.forget();
    snapshot.tracker_frame = chunk->tracker_frame;
    frame_ns = chunk->receive_ns;
    if (!table.resize(chunk->node_total)) return false;
    for (std::size_t i = 0; i < chunk->positions.size(); ++i) table.put(chunk->first_node + i, chunk->positions[i]);
    return table.complete();
  });
  snapshot.nodes = table.take();
  return snapshot;
}

std::vector<std::array<std::uint32_t, 4>> PredictionClient::cells(CellKind kind) {
  PiecewiseTable<std::array<std::uint32_t, 4>> table;
  ask(QueryTopology{kind}, [&](const ReceivedMessage& received) {
    const auto* chunk = std::get_if<MeshCells>(&received.message);
    if (chunk == nullptr || chunk->kind != kind) return false;
    if (!table.resize(chunk->cell_total)) return false;
    for (std::size_t i = 0; i < chunk->cells.size(); ++i) table.put(chunk->first_cell + i, chunk->cells[i]);
    return table.complete();
  });
  return table.take();
}

SubscribeReply PredictionClient::subscribe(const Subscribe& request) {
  SubscribeReply reply;
  ask(request, [&](const ReceivedMessage& received) {
    const auto* message = std::get_if<SubscribeReply>(&received.message);
    if (message != nullptr) reply = *message;
    return message != nullptr;
  });
  return reply;
}

void PredictionClient::unsubscribe() { send(Unsubscribe{}); }

}  // namespace tissued::daemon
