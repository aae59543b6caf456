#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "config/daemon_config.hpp"
#include "core/scene.hpp"
#include "daemon/answer_sender.hpp"
#include "daemon/bulk_transfers.hpp"
#include "daemon/counters.hpp"
#include "daemon/introduction.hpp"
#include "daemon/message_sender.hpp"
#include "daemon/peer_table.hpp"
#include "daemon/sealed_port.hpp"
#include "daemon/session_recorder.hpp"
#include "daemon/simulation_thread.hpp"
#include "protocol/address_cookie.hpp"
#include "protocol/client_messages.hpp"

namespace tissued::daemon {

/// Answers clients from the newest answer, and streams answers to subscribers as they are published. While the tracker
/// is silent subscribers go on to get the last answer, with its growing age, at their rate (at most 100 a second; 10 a
/// second where they asked for every frame). Status goes out at the subscriber's rate, at most 10 times a second.
/// Where there are keys, nobody else is heard; where addresses are to be proven, nobody is sent more than he sent
/// before.
class ClientServer {
 public:
  /// Binds the socket; throws BindError. References must outlive this. tracker_rate_hz: of the frames received.
  /// recorder: null, or what is told every datagram; outlives this, too.
  ClientServer(boost::asio::io_context& context, const config::DaemonConfig& config, const core::Scene& scene,
               SimulationThread& simulation, Counters& counters, std::function<double()> tracker_rate_hz,
               SessionRecorder* recorder = nullptr);

  void start();
  void close();
  /// Takes on staleness, leases and allowances.
  void apply(const config::DaemonConfig& config);
  /// Believes these instead, where there were keys at the start; whoever has still one of them comes back by himself.
  void use(std::span<const config::PreSharedKey> keys);
  std::uint16_t port() const { return port_; }

  /// The simulation has published something. Whether it is an answer.
  bool on_published();

  const AnswerSender& answers() const { return answers_; }

 private:
  void wait_readable();
  void drain();
  void serve(std::span<const std::uint8_t> bytes, SealedPort::Contact contact);
  Peer* admit(const protocol::DecodedMessage& request, std::size_t size);
  void meet(Peer& peer, SealedPort::Contact contact);
  void keep_contact(const Peer& peer, bool kept);
  void refuse(Peer& peer, const protocol::DecodedMessage& request);
  bool is_repeated(Peer& peer, const protocol::Header& header);

  // One for each request; the last takes what is none.
  void handle(Peer& peer, std::uint32_t sequence, const protocol::Hello&);
  void handle(Peer& peer, std::uint32_t sequence, const protocol::QueryNames& request);
  void handle(Peer& peer, std::uint32_t sequence, const protocol::QueryTargets&);
  void handle(Peer& peer, std::uint32_t sequence, const protocol::QueryMesh& request);
  void handle(Peer& peer, std::uint32_t sequence, const protocol::QueryTopology& request);
  void handle(Peer& peer, std::uint32_t sequence, const protocol::QueryStatus&);
  void handle(Peer& peer, std::uint32_t sequence, const protocol::QueryProbes&);
  void handle(Peer& peer, std::uint32_t sequence, const protocol::ProveAddress&);
  void handle(Peer& peer, std::uint32_t sequence, const protocol::Subscribe& request);
  void handle(Peer& peer, std::uint32_t sequence, const protocol::Unsubscribe&);
  template <typename NotARequest>
  void handle(Peer& peer, std::uint32_t sequence, const NotARequest&);

  void stream(Peer& peer, std::uint64_t now_ns, bool fresh);
  void serve_mesh_wishes();

  void start_ticking();
  void tick();
  void tick(Peer& peer, std::uint64_t now_ns);

  boost::asio::ip::udp::socket socket_;
  boost::asio::steady_timer ticker_;
  std::uint16_t port_ = 0;
  std::uint64_t max_lease_ns_;
  double max_requests_per_s_;
  bool prove_addresses_;
  std::unique_ptr<SealedPort> sealed_;  // null: there are no keys
  protocol::AddressCookie cookie_;
  SimulationThread& simulation_;
  Counters& counters_;
  SessionRecorder* recorder_;
  PeerTable peers_;
  MessageSender sender_;
  AnswerSender answers_;
  BulkTransfers bulk_;
  Introduction introduction_;
  bool ticking_ = false;
  bool mesh_requested_ = false;
  bool serving_mesh_wishes_ = false;
  boost::asio::ip::udp::endpoint sender_endpoint_;
  std::array<std::uint8_t, protocol::kMaxSealed + 1> buffer_{};  // one more, to tell what is too long
};

}  // namespace tissued::daemon
