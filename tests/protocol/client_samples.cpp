#include "tests/protocol/client_samples.hpp"

#include <numeric>
#include <string_view>
#include <utility>

namespace tissued::protocol {

namespace {

Name name(std::string_view text) { return Name::from(text).value(); }

HelloReply hello_reply() {
  HelloReply message;
  message.version = name("0.1.0");
  message.model = name("table1");
  message.simulator = name("kf-admm");
  message.units = name("mm s N");
  message.nominal_rate_hz = 100.5;
  message.node_count = 101;
  message.tetrahedron_count = 102;
  message.triangle_count = 103;
  message.target_count = 104;
  message.marker_count = 105;
  message.pad_count = 106;
  return message;
}

Names names() {
  Names message;
  message.kind = NameKind::pad;
  message.total = 9;
  message.first = 5;
  for (const char* text : {"A1", "pad of 24 characters :-)", "A3"}) message.names.push_back(name(text));
  return message;
}

Predictions predictions() {
  Predictions message;
  message.part = 1;
  message.part_count = 3;
  message.validity = Validity::degraded;
  message.has_stamp = true;
  message.reasons = 0x0102;
  message.iterations = 11;
  message.markers_used = 12;
  message.markers_seen = 13;
  message.tracker_frame = 14;
  message.stamp_ns = 15;
  message.receive_ns = 16;
  message.send_ns = 17;
  message.age_ns = 18;
  message.step_time_ns = 19;
  message.primal_residual = 0.25;
  message.dual_residual = 0.5;
  message.innovation_rms = 0.75;
  message.alarm = {true, true, true, 41, 42, 1.5, 0.125, {13, -14, 15}};
  message.targets.push_back({10, {1, 2, 3}, {4, -5, 6, 7, -8, 9}, true, {10, 11, 12}});
  message.targets.push_back({11, {-1, -2, -3}, {0, 0, 0, 0, 0, 0}, false, {}});
  message.pads.push_back({8, {1.5, -2.5, 3.5}});
  message.pads.push_back({9, {-4.5, 5.5, -6.5}});
  message.pads.push_back({10, {7.5, 8.5, 9.5}});
  return message;
}

MeshPositions positions(Precision precision) {
  MeshPositions message;
  message.tracker_frame = 21;
  message.receive_ns = 22;
  message.send_ns = 23;
  message.precision = precision;
  const std::size_t per_chunk = nodes_per_chunk(precision);
  message.chunk = 2;
  message.chunk_count = 3;
  message.node_total = static_cast<std::uint32_t>(2 * per_chunk + 4);
  message.first_node = static_cast<std::uint32_t>(2 * per_chunk);
  for (int i = 0; i < 4; ++i) message.positions.push_back({0.5 + i, -1.5 * i, 100.25});
  return message;
}

MeshCells cells(CellKind kind) {
  MeshCells message;
  message.kind = kind;
  const std::size_t per_chunk = cells_per_chunk(kind);
  message.chunk = 1;
  message.chunk_count = 2;
  message.node_total = 70000;
  message.cell_total = static_cast<std::uint32_t>(per_chunk + 3);
  message.first_cell = static_cast<std::uint32_t>(per_chunk);
  for (std::uint32_t i = 0; i < 3; ++i) {
    message.cells.push_back({i, 1000 + i, 69999 - i, kind == CellKind::tetrahedron ? 300 + i : 0});
  }
  return message;
}

Status status() {
  Status message;
  message.part = 1;
  message.part_count = 2;
  message.validity = Validity::invalid;
  message.reasons = 0x0403;
  message.subscribers = 31;
  message.uptime_ns = 32;
  message.send_ns = 33;
  message.latency_p50_ns = 34;
  message.latency_p99_ns = 35;
  message.latency_max_ns = 36;
  message.step_p50_ns = 37;
  message.step_p99_ns = 38;
  message.step_max_ns = 39;
  message.tracker_rate_hz = 99.5;
  message.step_rate_hz = 98.5;
  message.alarm = {true, true, true, 51, 52, 1.25, 0.375, {-16, 17, -18}};
  message.counters.push_back({100, 0x0102030405060708});
  message.counters.push_back({101, 0});
  return message;
}

ProbeView probe_view() {
  ProbeView message;
  message.part = 1;
  message.part_count = 2;
  message.validity = Validity::degraded;
  message.seen = true;
  message.has_image = true;
  message.reasons = 0x0205;
  message.index = 2;
  message.probe_count = 3;
  message.tracker_frame = 61;
  message.receive_ns = 62;
  message.send_ns = 63;
  message.age_ns = 64;
  message.force = {0.5, -1.5, -2.5};
  message.size = {640, 480};
  message.spacing = {0.125, 0.25};
  message.targets.push_back({20, true, {100.5, -200.25}, -3.5, 0.75, {9.0, 4.0}, -0.5});
  message.targets.push_back({21, false, {-1000.0, 2000.0}, 40.0, 0.0, {0.0, 0.0}, 0.0});
  return message;
}

CookieBytes cookie(std::uint8_t first) {
  CookieBytes bytes;
  std::iota(bytes.begin(), bytes.end(), first);
  return bytes;
}

}  // namespace

std::vector<Sample> client_samples() {
  std::vector<ClientMessage> messages{Hello{name("watcher")},
                                      QueryNames{NameKind::counter},
                                      QueryTargets{},
                                      QueryMesh{Precision::float64},
                                      QueryTopology{CellKind::skin_triangle},
                                      QueryStatus{},
                                      Subscribe{kTargets | kStatus, Precision::float64, 600, 62.5},
                                      Unsubscribe{},
                                      hello_reply(),
                                      names(),
                                      predictions(),
                                      positions(Precision::float32),
                                      positions(Precision::float64),
                                      cells(CellKind::tetrahedron),
                                      cells(CellKind::skin_triangle),
                                      status(),
                                      SubscribeReply{kMesh, Precision::float32, 0, 0.5},
                                      Error{ErrorReason::refused, ClientRefusal::unknown_type, 0x7E},
                                      QueryProbes{},
                                      probe_view(),
                                      ProveAddress{cookie(0x10)},
                                      AddressProof{cookie(0xA0)}};
  std::vector<Sample> samples;
  for (std::uint32_t i = 0; i < messages.size(); ++i) {
    samples.push_back({{0xA0B0C0D0 + i, 0x01020304 + i, 0x10203040 + i}, std::move(messages[i])});
  }
  return samples;
}

std::vector<std::uint8_t> encoded(const Envelope& envelope, const ClientMessage& message) {
  std::vector<std::uint8_t> buffer(kMaxDatagram);
  buffer.resize(std::visit([&](const auto& m) { return encode_client_message(envelope, m, buffer); }, message));
  return buffer;
}

}  // namespace tissued::protocol
