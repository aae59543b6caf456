// Meshes and topology through the daemon: real sockets, a fake simulator.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <set>

#include "tests/daemon/loopback_peers.hpp"
#include "tests/daemon/running_daemon.hpp"
#include "tests/daemon/tracker_frames.hpp"

using namespace tissued;
using protocol::MeshCells;
using protocol::MeshPositions;
using protocol::Precision;

TEST_CASE("A mesh of any size arrives whole, in chunks, of one moment") {
  const int nodes = GENERATE(4, 110, 111, 5000);
  const auto precision = GENERATE(Precision::float32, Precision::float64);
  RunningDaemon daemon(small_config(), long_scene(nodes));
  FakeTracker tracker(daemon.runtime.tracker_port());
  FakeClient client(daemon.runtime.client_port());
  tracker.send(frame_with_shift(1, 2.0).frame);
  REQUIRE(eventually([&] { return daemon.simulator.steps == 1; }));
  const std::uint32_t sequence = client.send(protocol::QueryMesh{precision});
  std::set<std::uint16_t> chunks;
  std::size_t chunk_count = 1;
  std::size_t right = 0;
  while (chunks.size() < chunk_count) {
    const auto message = client.await<MeshPositions>();
    REQUIRE(client.header.envelope.in_reply_to == sequence);
    CHECK(message.tracker_frame == 1);
    CHECK(message.node_total == static_cast<std::uint32_t>(nodes));
    chunk_count = message.chunk_count;
    chunks.insert(message.chunk);
    for (std::size_t i = 0; i < message.positions.size(); ++i) {
      const double x = 2.0 + 0.001 * static_cast<double>(message.first_node + i);
      const auto& p = message.positions[i];
      if (std::abs(p[0] - x) < (precision == Precision::float32 ? 1e-6 : 1e-12) && p[1] == 0.5 && p[2] == -1.25)
        ++right;
    }
    // While the tracker goes on, the chunks of one transfer stay of one moment.
    tracker.send(frame_with_shift(1 + static_cast<std::uint32_t>(chunks.size()), 3.0).frame);
  }
  CHECK(right == static_cast<std::size_t>(nodes));
}

TEST_CASE("Topology: tetrahedra and skin triangles, with the scene's own indices") {
  RunningDaemon daemon(small_config(), long_scene(1000));
  FakeClient client(daemon.runtime.client_port());
  client.send(protocol::QueryTopology{protocol::CellKind::tetrahedron});
  std::size_t cells = 0;
  while (cells < 1000) {
    const auto message = client.await<MeshCells>();
    CHECK(message.cell_total == 1000);
    CHECK(message.first_cell == cells);
    for (const auto& cell : message.cells) {
      CHECK(cell[0] == cells);
      CHECK(cell[3] == (cells + 3) % 1000);
      ++cells;
    }
  }
  const auto skin = client.ask<MeshCells>(protocol::QueryTopology{protocol::CellKind::skin_triangle});
  REQUIRE(skin.cells.size() == 3);
  CHECK(skin.cells[2] == std::array<std::uint32_t, 4>{1, 2, 3, 0});
}
