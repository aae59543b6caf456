#include "daemon/client_server.hpp"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <chrono>
#include <random>
#include <utility>
#include <variant>

#include "daemon/bound_socket.hpp"
#include "daemon/monotonic_clock.hpp"
#include "daemon/source_address.hpp"

namespace tissued::daemon {

namespace {

using boost::asio::ip::udp;

constexpr int kMaxDrain = 64;  // requests before the tracker has its turn again
constexpr std::chrono::milliseconds kTick{10};
constexpr std::uint64_t kShortestHeldPeriod_ns = 10'000'000;  // of a held answer to one subscriber
constexpr std::uint64_t kHeldPeriod_ns = 100'000'000;         // the same, where every frame was asked for
constexpr std::uint64_t kShortestStatusPeriod_ns = 100'000'000;
constexpr std::size_t kErrorSize = protocol::kHeaderSize + 4;

}  // namespace

ClientServer::ClientServer(boost::asio::io_context& context, const config::DaemonConfig& config,
                           const core::Scene& scene, SimulationThread& simulation, Counters& counters,
                           std::function<double()> tracker_rate_hz, SessionRecorder* recorder)
    : socket_(bind_udp(context, "clients", config.clients.address, config.clients.port)),
      ticker_(context),
      port_(socket_.local_endpoint().port()),
      max_lease_ns_(static_cast<std::uint64_t>(config.clients.lease.count())),
      max_requests_per_s_(config.clients.max_requests_per_s),
      prove_addresses_(config.clients.prove_addresses),
      sealed_(SealedPort::make(socket_, protocol::SealChannel::client, config.keys, counters)),
      simulation_(simulation),
      counters_(counters),
      recorder_(recorder),
      peers_(static_cast<std::size_t>(config.clients.max_subscribers)),
      sender_(socket_, std::random_device{}(), counters, sealed_.get()),
      answers_(config, scene, simulation, peers_, sender_, counters, std::move(tracker_rate_hz)),
      bulk_(context, scene, peers_, sender_, counters, [this] { serve_mesh_wishes(); }),
      introduction_(config, scene) {}

void ClientServer::start() { wait_readable(); }

void ClientServer::apply(const config::DaemonConfig& config) {
  answers_.apply(config.staleness);
  max_lease_ns_ = static_cast<std::uint64_t>(config.clients.lease.count());
  max_requests_per_s_ = config.clients.max_requests_per_s;
}

void ClientServer::use(std::span<const config::PreSharedKey> keys) {
  if (sealed_) sealed_->use(keys);
}

void ClientServer::close() {
  boost::system::error_code ignored;
  socket_.close(ignored);
}

void ClientServer::wait_readable() {
  socket_.async_wait(udp::socket::wait_read, [this](const boost::system::error_code& error) {
    if (error) return;
    drain();
    wait_readable();
  });
}

void ClientServer::drain() {
  for (int i = 0; i < kMaxDrain; ++i) {
    boost::system::error_code error;
    const std::size_t size = socket_.receive_from(boost::asio::buffer(buffer_), sender_endpoint_, 0, error);
    if (error == boost::asio::error::would_block) return;
    if (error) continue;  // an earlier datagram of ours found nobody; it has no place here
    counters_.add(Count::client_datagrams);
    auto bytes = std::span<const std::uint8_t>(buffer_).first(size);
    SealedPort::Contact contact;
    if (sealed_) {
      const auto opened = sealed_->open(bytes, sender_endpoint_);
      if (!opened) continue;
      bytes = opened->payload;
      contact = opened->contact;
    }
    if (recorder_ != nullptr) recorder_->add_client(monotonic_ns(), bytes);
    serve(bytes, contact);
  }
}

void ClientServer::serve(std::span<const std::uint8_t> bytes, SealedPort::Contact contact) {
  const protocol::DecodedMessage request = protocol::decode_client_message(bytes);
  counters_.add(request.refusal);
  // Nothing that speaks our protocol sent it: no answer, and no place in the table.
  using protocol::ClientRefusal;
  const ClientRefusal refusal = request.refusal;
  const bool foreign =
      refusal == ClientRefusal::too_short || refusal == ClientRefusal::too_long || refusal == ClientRefusal::bad_magic;
  if (foreign) return;
  Peer* peer = admit(request, bytes.size());
  if (peer == nullptr) return;
  meet(*peer, contact);
  if (!peer->allowance.take(max_requests_per_s_, monotonic_ns())) return counters_.add(Count::requests_limited);
  if (refusal != ClientRefusal::none) {
    refuse(*peer, request);
  } else if (!is_repeated(*peer, request.header)) {
    std::visit([&](const auto& message) { handle(*peer, request.header.envelope.sequence, message); }, request.message);
  }
}

// Who asks, or null where he has to show first that he receives where he sends from.
Peer* ClientServer::admit(const protocol::DecodedMessage& request, std::size_t size) {
  const std::uint64_t now_ns = monotonic_ns();
  if (!prove_addresses_) return &peers_.hear(sender_endpoint_, now_ns);
  if (peers_.find(sender_endpoint_) != nullptr) return &peers_.hear(sender_endpoint_, now_ns);
  counters_.add(Count::requests_unproven);
  const auto* proof = std::get_if<protocol::ProveAddress>(&request.message);
  if (request.refusal == protocol::ClientRefusal::none && proof != nullptr) {
    const auto source = source_address(sender_endpoint_);
    if (cookie_.is_good(proof->cookie, source, now_ns)) return &peers_.hear(sender_endpoint_, now_ns);
    sender_.send_to(sender_endpoint_, request.header.envelope.sequence,
                    protocol::AddressProof{cookie_.make(source, now_ns)});
  } else if (size >= kErrorSize &&
             request.header.type_code != static_cast<std::uint8_t>(protocol::MessageType::error)) {
    sender_.send_to(sender_endpoint_, request.header.envelope.sequence,
                    protocol::Error{protocol::ErrorReason::address_unproven, protocol::ClientRefusal::none,
                                    request.header.type_code});
  }
  return nullptr;
}

// A client that begins anew at its old address takes its subscription along.
void ClientServer::meet(Peer& peer, SealedPort::Contact contact) {
  if (peer.contact == contact) return;
  if (peer.grant) keep_contact(peer, false);
  peer.contact = contact;
  if (peer.grant) keep_contact(peer, true);
}

void ClientServer::keep_contact(const Peer& peer, bool kept) {
  if (sealed_) sealed_->keep(peer.contact, kept);
}

void ClientServer::refuse(Peer& peer, const protocol::DecodedMessage& request) {
  // Two that answer errors with errors would never stop.
  if (request.header.type_code == static_cast<std::uint8_t>(protocol::MessageType::error)) return;
  sender_.send(peer, request.header.envelope.sequence,
               protocol::Error{protocol::ErrorReason::refused, request.refusal, request.header.type_code});
}

// A datagram that the network doubled, or one so old that it may be: answering once is enough. A subscription that was
// overtaken by a later request would undo that.
bool ClientServer::is_repeated(Peer& peer, const protocol::Header& header) {
  using protocol::SequenceVerdict;
  const SequenceVerdict verdict = peer.gate.judge(header.envelope);
  const bool changes_subscription =
      header.type == protocol::MessageType::subscribe || header.type == protocol::MessageType::unsubscribe;
  const bool repeated = verdict == SequenceVerdict::duplicate || verdict == SequenceVerdict::too_old ||
                        (verdict == SequenceVerdict::late && changes_subscription);
  if (repeated) counters_.add(Count::requests_repeated);
  return repeated;
}

void ClientServer::handle(Peer& peer, std::uint32_t sequence, const protocol::Hello&) {
  sender_.send(peer, sequence, introduction_.hello());
}

void ClientServer::handle(Peer& peer, std::uint32_t sequence, const protocol::QueryNames& request) {
  introduction_.for_each_part(request.kind, [&](const protocol::Names& part) { sender_.send(peer, sequence, part); });
}

void ClientServer::handle(Peer& peer, std::uint32_t sequence, const protocol::QueryTargets&) {
  answers_.send_predictions(peer, sequence, false);
}

void ClientServer::handle(Peer& peer, std::uint32_t sequence, const protocol::QueryMesh& request) {
  if (peer.mesh_wish) counters_.add(Count::transfers_refused);
  peer.mesh_wish = MeshWish{sequence, request.precision};
  serve_mesh_wishes();
}

void ClientServer::handle(Peer& peer, std::uint32_t sequence, const protocol::QueryTopology& request) {
  const bool tetrahedra = request.kind == protocol::CellKind::tetrahedron;
  bulk_.begin(peer, tetrahedra ? BulkTransfers::Content::tetrahedra : BulkTransfers::Content::skin_triangles, sequence,
              nullptr);
}

void ClientServer::handle(Peer& peer, std::uint32_t sequence, const protocol::QueryStatus&) {
  answers_.send_status(peer, sequence);
}

void ClientServer::handle(Peer& peer, std::uint32_t sequence, const protocol::QueryProbes&) {
  if (!simulation_.answer().probes.empty()) return answers_.send_probe_views(peer, sequence);
  sender_.send(peer, sequence,
               protocol::Error{protocol::ErrorReason::not_available, protocol::ClientRefusal::none,
                               static_cast<std::uint8_t>(protocol::MessageType::query_probes)});
}

void ClientServer::handle(Peer& peer, std::uint32_t sequence, const protocol::ProveAddress&) {
  sender_.send(peer, sequence, protocol::AddressProof{});  // whoever has a place has proven it, or need not
}

void ClientServer::handle(Peer& peer, std::uint32_t sequence, const protocol::Subscribe& request) {
  const std::uint64_t now_ns = monotonic_ns();
  const std::uint64_t lease_ns = std::min(request.lease_s * std::uint64_t{1'000'000'000}, max_lease_ns_);
  Grant grant;
  grant.what = request.what;
  grant.precision = request.precision;
  grant.period_ns = request.rate_hz > 0.0 ? static_cast<std::uint64_t>(1e9 / request.rate_hz) : 0;
  grant.expires_ns = now_ns + lease_ns;
  grant.due_ns = now_ns;
  grant.status_due_ns = now_ns;
  if (peer.grant && peer.grant->streams_like(grant)) {
    peer.grant->expires_ns = grant.expires_ns;  // a renewal does not disturb the stream's beat
  } else if (!peers_.subscribe(peer, grant)) {
    counters_.add(Count::clients_refused);
    sender_.send(peer, sequence,
                 protocol::Error{protocol::ErrorReason::too_many_clients, protocol::ClientRefusal::none,
                                 static_cast<std::uint8_t>(protocol::MessageType::subscribe)});
    return;
  }
  keep_contact(peer, true);
  // Whole seconds on the wire, where 0 means that there is no subscription.
  const auto lease_s = std::max<std::uint64_t>(1, lease_ns / 1'000'000'000);
  sender_.send(
      peer, sequence,
      protocol::SubscribeReply{request.what, request.precision, static_cast<std::uint16_t>(lease_s), request.rate_hz});
  start_ticking();
}

void ClientServer::handle(Peer& peer, std::uint32_t sequence, const protocol::Unsubscribe&) {
  peers_.unsubscribe(peer);
  keep_contact(peer, false);
  sender_.send(peer, sequence, protocol::SubscribeReply{});
}

template <typename NotARequest>
void ClientServer::handle(Peer& peer, std::uint32_t sequence, const NotARequest&) {
  if constexpr (!std::is_same_v<NotARequest, protocol::Error>) {
    sender_.send(peer, sequence,
                 protocol::Error{protocol::ErrorReason::not_a_request, protocol::ClientRefusal::none,
                                 static_cast<std::uint8_t>(NotARequest::kType)});
  }
}

bool ClientServer::on_published() {
  const bool answered = simulation_.fetch_answer();
  if (answered) {
    const std::uint64_t now_ns = monotonic_ns();
    answers_.note_step(now_ns);
    for (Peer& peer : peers_.all()) {
      // A frame that comes a little early is not left to wait for the next: trackers jitter.
      if (peer.grant && now_ns + peer.grant->period_ns / 4 >= peer.grant->due_ns) stream(peer, now_ns, true);
    }
  }
  serve_mesh_wishes();
  return answered;
}

void ClientServer::stream(Peer& peer, std::uint64_t now_ns, bool fresh) {
  Grant& grant = *peer.grant;
  if (grant.what & protocol::kTargets) answers_.send_predictions(peer, 0, fresh);
  if (grant.what & protocol::kProbes) answers_.send_probe_views(peer, 0);
  const auto divisor = OverloadRule::mesh_divisor(simulation_.answer().overload);
  if ((grant.what & protocol::kMesh) && !peer.mesh_wish && grant.meshes_due++ % divisor == 0)
    peer.mesh_wish = MeshWish{0, grant.precision};
  grant.due_ns = std::max(grant.due_ns + grant.period_ns, now_ns);
  grant.last_sent_ns = now_ns;
}

// Node positions are copied out only when somebody wants them, and all who wait get the same.
void ClientServer::serve_mesh_wishes() {
  if (bulk_.mesh_under_way() || serving_mesh_wishes_) return;
  const auto peers = peers_.all();
  if (std::none_of(peers.begin(), peers.end(), [](const Peer& peer) { return peer.mesh_wish.has_value(); })) {
    // Who asked has gone: nobody must get that mesh later as if it were new.
    if (mesh_requested_ && simulation_.fetch_mesh()) mesh_requested_ = false;
    return;
  }
  if (!simulation_.fetch_mesh()) {
    if (!mesh_requested_) simulation_.request_mesh();
    mesh_requested_ = true;
    return;
  }
  mesh_requested_ = false;
  serving_mesh_wishes_ = true;  // a mesh that is sent at once calls back here
  for (Peer& peer : peers) {
    if (!peer.mesh_wish) continue;
    const MeshWish wish = *std::exchange(peer.mesh_wish, std::nullopt);
    const bool single = wish.precision == protocol::Precision::float32;
    bulk_.begin(peer, single ? BulkTransfers::Content::mesh_float32 : BulkTransfers::Content::mesh_float64,
                wish.in_reply_to, &simulation_.mesh());
  }
  serving_mesh_wishes_ = false;
}

void ClientServer::start_ticking() {
  if (ticking_) return;
  ticking_ = true;
  ticker_.expires_after(kTick);
  ticker_.async_wait([this](const boost::system::error_code& error) {
    ticking_ = false;
    if (!error) tick();
  });
}

// What time alone brings about for subscribers; without any the daemon sleeps until a datagram comes.
void ClientServer::tick() {
  const std::uint64_t now_ns = monotonic_ns();
  for (Peer& peer : peers_.all()) {
    if (peer.grant) tick(peer, now_ns);
  }
  serve_mesh_wishes();
  if (peers_.subscriber_count() > 0) start_ticking();
}

void ClientServer::tick(Peer& peer, std::uint64_t now_ns) {
  Grant& grant = *peer.grant;
  if (now_ns >= grant.expires_ns) {
    counters_.add(Count::leases_expired);
    peers_.unsubscribe(peer);
    keep_contact(peer, false);
    return;
  }
  const bool silent = answers_.is_stale(now_ns);
  const std::uint64_t held_period_ns =
      grant.period_ns > 0 ? std::max(grant.period_ns, kShortestHeldPeriod_ns) : kHeldPeriod_ns;
  const bool streams_answers = (grant.what & (protocol::kTargets | protocol::kMesh | protocol::kProbes)) != 0;
  if (silent && streams_answers && now_ns >= grant.last_sent_ns + held_period_ns) stream(peer, now_ns, false);
  if ((grant.what & protocol::kStatus) && now_ns >= grant.status_due_ns) {
    answers_.send_status(peer, 0);
    grant.status_due_ns = now_ns + std::max(grant.period_ns, kShortestStatusPeriod_ns);
  }
}

}  // namespace tissued::daemon
