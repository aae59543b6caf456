#include "tests/daemon/fake_daemon.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>

#include "daemon/monotonic_clock.hpp"
#include "protocol/vicon_stream.hpp"

namespace tissued::daemon {
namespace {

using namespace protocol;

constexpr std::uint32_t kSession = 77;

int bound_socket(std::uint16_t& port) {
  const int descriptor = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (bind(descriptor, reinterpret_cast<sockaddr*>(&address), size) != 0) std::abort();
  getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size);
  port = ntohs(address.sin_port);
  return descriptor;
}

}  // namespace

FakeDaemon::FakeDaemon(FakeDaemonScript script)
    : script_(std::move(script)),
      tracker_socket_(bound_socket(tracker_port_)),
      client_socket_(bound_socket(client_port_)),
      assembler_(FrameAssemblerConfig{}),
      thread_([this] { run(); }) {}

FakeDaemon::~FakeDaemon() {
  stop_ = true;
  thread_.join();
  close(tracker_socket_);
  close(client_socket_);
}

std::vector<TrackerFrame> FakeDaemon::frames() const {
  const std::lock_guard lock(frames_mutex_);
  return frames_;
}

void FakeDaemon::run() {
  std::array<pollfd, 2> sockets{{{tracker_socket_, POLLIN, 0}, {client_socket_, POLLIN, 0}}};
  while (!stop_) {
    if (poll(sockets.data(), sockets.size(), 10) <= 0) continue;
    if (sockets[0].revents != 0) serve_tracker();
    if (sockets[1].revents != 0) serve_client();
  }
}

void FakeDaemon::serve_tracker() {
  std::array<std::uint8_t, 2048> buffer;
  const ssize_t size = recv(tracker_socket_, buffer.data(), buffer.size(), 0);
  TrackerDatagram datagram;
  if (size < 0 || decode_tracker_datagram(std::span(buffer).first(size), datagram) != TrackerRefusal::none) {
    ++refused_;
    return;
  }
  for (const TrackerFrame& frame : assembler_.add(datagram, monotonic_ns())) {
    std::uint64_t number = 0;
    {
      const std::lock_guard lock(frames_mutex_);
      number = frames_.size();
      frames_.push_back(frame);
    }
    latest_ = frame;
    if (subscribed_ && script_.answers(number)) send(0, predictions());
  }
}

void FakeDaemon::serve_client() {
  std::array<std::uint8_t, 2048> buffer;
  socklen_t length = sizeof peer_;
  const ssize_t size =
      recvfrom(client_socket_, buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&peer_), &length);
  if (size < 0) return;
  const DecodedMessage decoded = decode_client_message(std::span(buffer).first(size));
  if (decoded.refusal != ClientRefusal::none) {
    ++refused_;
    return;
  }
  answer(decoded.header, decoded.message);
}

void FakeDaemon::answer(const Header& header, const ClientMessage& request) {
  const std::uint32_t asked = header.envelope.sequence;
  if (std::holds_alternative<Hello>(request)) {
    HelloReply reply;
    reply.version = *Name::from("9.9.9");
    reply.model = *Name::from("fake");
    reply.simulator = *Name::from("none");
    reply.units = *Name::from("mm s N");
    reply.nominal_rate_hz = 100;
    reply.node_count = static_cast<std::uint32_t>(script_.nodes.size());
    reply.target_count = static_cast<std::uint16_t>(script_.targets.size());
    send(asked, reply);
  } else if (const auto* names = std::get_if<QueryNames>(&request)) {
    answer_names(asked, names->kind);
  } else if (std::holds_alternative<QueryTargets>(request)) {
    send(asked, predictions());
  } else if (const auto* mesh = std::get_if<QueryMesh>(&request)) {
    answer_mesh(asked, mesh->precision);
  } else if (std::holds_alternative<QueryTopology>(request)) {
    answer_topology(asked);
  } else if (std::holds_alternative<QueryStatus>(request)) {
    Status status;
    status.validity = Validity::valid;
    for (std::size_t i = 0; i < script_.counters.size(); ++i) {
      status.counters.push_back({static_cast<std::uint16_t>(i), 100 + i});
    }
    send(asked, status);
  } else if (const auto* subscribe = std::get_if<Subscribe>(&request)) {
    subscribed_ = true;
    SubscribeReply reply;
    reply.what = subscribe->what;
    reply.rate_hz = subscribe->rate_hz;
    reply.lease_s = subscribe->lease_s;
    send(asked, reply);
  } else if (std::holds_alternative<Unsubscribe>(request)) {
    subscribed_ = false;
  }
}

void FakeDaemon::answer_names(std::uint32_t in_reply_to, NameKind kind) {
  const std::vector<std::string> none;
  const auto& table = kind == NameKind::target    ? script_.targets
                      : kind == NameKind::pad     ? script_.pads
                      : kind == NameKind::counter ? script_.counters
                                                  : none;
  std::size_t first = 0;
  do {
    Names names;
    names.kind = kind;
    names.total = static_cast<std::uint16_t>(table.size());
    names.first = static_cast<std::uint16_t>(first);
    while (first < table.size() && names.names.push_back(*Name::from(table[first]))) ++first;
    send(in_reply_to, names);
  } while (first < table.size());
}

void FakeDaemon::answer_mesh(std::uint32_t in_reply_to, Precision precision) {
  if (script_.mesh_not_available) {
    Error error;
    error.reason = ErrorReason::not_available;
    error.request_type = static_cast<std::uint8_t>(MessageType::query_mesh);
    return send(in_reply_to, error);
  }
  const std::size_t per_chunk = nodes_per_chunk(precision);
  const std::size_t chunks = chunk_count(script_.nodes.size(), per_chunk);
  for (std::size_t c = 0; c < chunks; ++c) {
    MeshPositions chunk;
    chunk.tracker_frame = 5;
    chunk.receive_ns = 1234;
    chunk.chunk = static_cast<std::uint16_t>(c);
    chunk.chunk_count = static_cast<std::uint16_t>(chunks);
    chunk.node_total = static_cast<std::uint32_t>(script_.nodes.size());
    chunk.first_node = static_cast<std::uint32_t>(c * per_chunk);
    chunk.precision = precision;
    for (std::size_t i = c * per_chunk; i < std::min((c + 1) * per_chunk, script_.nodes.size()); ++i) {
      chunk.positions.push_back(script_.nodes[i]);
    }
    send(in_reply_to, chunk);
  }
}

void FakeDaemon::answer_topology(std::uint32_t in_reply_to) {
  const std::size_t per_chunk = cells_per_chunk(CellKind::tetrahedron);
  const std::size_t chunks = chunk_count(script_.tets.size(), per_chunk);
  for (std::size_t c = 0; c < chunks; ++c) {
    MeshCells chunk;
    chunk.chunk = static_cast<std::uint16_t>(c);
    chunk.chunk_count = static_cast<std::uint16_t>(chunks);
    chunk.node_total = static_cast<std::uint32_t>(script_.nodes.size());
    chunk.cell_total = static_cast<std::uint32_t>(script_.tets.size());
    chunk.first_cell = static_cast<std::uint32_t>(c * per_chunk);
    for (std::size_t i = c * per_chunk; i < std::min((c + 1) * per_chunk, script_.tets.size()); ++i) {
      chunk.cells.push_back(script_.tets[i]);
    }
    send(in_reply_to, chunk);
  }
}

Predictions FakeDaemon::predictions() const {
  Predictions answer;
  if (!latest_) return answer;
  const TrackerFrame& frame = *latest_;
  answer.validity = Validity::valid;
  answer.tracker_frame = frame.frame_number;
  answer.has_stamp = frame.stamp_ns.has_value();
  answer.stamp_ns = frame.stamp_ns.value_or(0);
  answer.receive_ns = frame.receive_ns;
  answer.send_ns = monotonic_ns();
  answer.age_ns = answer.send_ns - answer.receive_ns;
  answer.markers_used = answer.markers_seen = static_cast<std::uint16_t>(frame.markers.size());
  for (std::size_t t = 0; t < script_.targets.size(); ++t) {
    TargetPrediction prediction;
    prediction.index = static_cast<std::uint16_t>(t);
    prediction.covariance = {script_.variance, 0, 0, script_.variance, 0, script_.variance};
    for (const TargetTruth& truth : frame.truth) {
      if (truth.name.view() != script_.targets[t]) continue;
      prediction.has_truth = true;
      prediction.truth = truth.position;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        prediction.position[axis] = truth.position[axis] + script_.offset[axis];
      }
    }
    answer.targets.push_back(prediction);
  }
  return answer;
}

template <typename Message>
void FakeDaemon::send(std::uint32_t in_reply_to, const Message& message) {
  std::array<std::uint8_t, kMaxDatagram> buffer;
  const std::size_t size = encode_client_message({kSession, ++sequence_, in_reply_to}, message, buffer);
  if (script_.loses(sent_++)) return;
  sendto(client_socket_, buffer.data(), size, 0, reinterpret_cast<const sockaddr*>(&peer_), sizeof peer_);
}

}  // namespace tissued::daemon
