#include "daemon/bulk_transfers.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "daemon/monotonic_clock.hpp"

namespace tissued::daemon {

namespace {

using protocol::CellKind;
using protocol::Precision;

constexpr int kChunksPerTurn = 32;  // 45 kB, some 150 us of one core
constexpr std::chrono::milliseconds kPause{1};
constexpr std::size_t kMaxTransfers = 128;

}  // namespace

BulkTransfers::BulkTransfers(boost::asio::io_context& context, const core::Scene& scene, PeerTable& peers,
                             MessageSender& sender, Counters& counters, std::function<void()> on_mesh_idle)
    : pause_(context),
      scene_(scene),
      skin_(scene.mesh.find_surface(scene.skin_surface)->triangles),
      peers_(peers),
      sender_(sender),
      counters_(counters),
      on_mesh_idle_(std::move(on_mesh_idle)) {
  transfers_.reserve(kMaxTransfers);
}

void BulkTransfers::begin(Peer& peer, Content content, std::uint32_t in_reply_to, const MeshSnapshot* mesh) {
  const bool under_way = std::any_of(transfers_.begin(), transfers_.end(), [&](const Transfer& transfer) {
    return transfer.content == content && transfer.endpoint == peer.endpoint;
  });
  if (under_way || transfers_.size() == kMaxTransfers) {
    counters_.add(Count::transfers_refused);
    return;
  }
  if (is_mesh(content)) {
    mesh_ = mesh;
    ++mesh_transfers_;
  }
  transfers_.push_back({peer.endpoint, content, in_reply_to, 0, chunk_count(content)});
  if (!pausing_) send_some();
}

std::size_t BulkTransfers::chunk_count(Content content) const {
  switch (content) {
    case Content::mesh_float32:
      return protocol::chunk_count(scene_.mesh.node_count(), protocol::nodes_per_chunk(Precision::float32));
    case Content::mesh_float64:
      return protocol::chunk_count(scene_.mesh.node_count(), protocol::nodes_per_chunk(Precision::float64));
    case Content::tetrahedra:
      return protocol::chunk_count(scene_.mesh.tets.size(), protocol::cells_per_chunk(CellKind::tetrahedron));
    case Content::skin_triangles:
      return protocol::chunk_count(skin_.size(), protocol::cells_per_chunk(CellKind::skin_triangle));
  }
  return 0;
}

// One chunk of each transfer in turn, so that a small mesh does not wait for a large one.
void BulkTransfers::send_some() {
  const bool mesh_was_under_way = mesh_under_way();
  int budget = kChunksPerTurn;
  while (budget > 0 && !transfers_.empty()) {
    for (std::size_t i = 0; i < transfers_.size() && budget > 0; --budget) {
      if (send_chunk(transfers_[i])) {
        ++i;
        continue;
      }
      if (is_mesh(transfers_[i].content)) --mesh_transfers_;
      transfers_.erase(transfers_.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  if (!transfers_.empty()) pause();
  if (mesh_was_under_way && !mesh_under_way()) on_mesh_idle_();
}

void BulkTransfers::pause() {
  pausing_ = true;
  pause_.expires_after(kPause);
  pause_.async_wait([this](const boost::system::error_code& error) {
    pausing_ = false;
    if (!error) send_some();
  });
}

// False when that was the last chunk, or the client has been forgotten.
bool BulkTransfers::send_chunk(Transfer& transfer) {
  Peer* peer = peers_.find(transfer.endpoint);
  if (peer == nullptr) return false;
  is_mesh(transfer.content) ? send_positions(*peer, transfer) : send_cells(*peer, transfer);
  return ++transfer.next_chunk < transfer.chunk_count;
}

void BulkTransfers::send_positions(Peer& peer, const Transfer& transfer) {
  protocol::MeshPositions message;
  message.precision = transfer.content == Content::mesh_float32 ? Precision::float32 : Precision::float64;
  message.tracker_frame = mesh_->tracker_frame;
  message.receive_ns = mesh_->receive_ns;
  message.send_ns = monotonic_ns();
  message.chunk = static_cast<std::uint16_t>(transfer.next_chunk);
  message.chunk_count = static_cast<std::uint16_t>(transfer.chunk_count);
  const std::size_t first = transfer.next_chunk * protocol::nodes_per_chunk(message.precision);
  const std::size_t end = std::min(first + protocol::nodes_per_chunk(message.precision), mesh_->positions.size());
  message.node_total = static_cast<std::uint32_t>(mesh_->positions.size());
  message.first_node = static_cast<std::uint32_t>(first);
  for (std::size_t i = first; i < end; ++i) message.positions.push_back(mesh_->positions[i]);
  sender_.send(peer, transfer.in_reply_to, message);
}

void BulkTransfers::send_cells(Peer& peer, const Transfer& transfer) {
  const auto corner = [](int node) { return static_cast<std::uint32_t>(node); };
  const bool tetrahedra = transfer.content == Content::tetrahedra;
  protocol::MeshCells message;
  message.kind = tetrahedra ? CellKind::tetrahedron : CellKind::skin_triangle;
  message.chunk = static_cast<std::uint16_t>(transfer.next_chunk);
  message.chunk_count = static_cast<std::uint16_t>(transfer.chunk_count);
  const std::size_t total = tetrahedra ? scene_.mesh.tets.size() : skin_.size();
  const std::size_t first = transfer.next_chunk * protocol::cells_per_chunk(message.kind);
  const std::size_t end = std::min(first + protocol::cells_per_chunk(message.kind), total);
  message.node_total = static_cast<std::uint32_t>(scene_.mesh.node_count());
  message.cell_total = static_cast<std::uint32_t>(total);
  message.first_cell = static_cast<std::uint32_t>(first);
  for (std::size_t i = first; i < end; ++i) {
    if (tetrahedra) {
      const auto& tet = scene_.mesh.tets[i];
      message.cells.push_back({corner(tet[0]), corner(tet[1]), corner(tet[2]), corner(tet[3])});
    } else {
      message.cells.push_back({corner(skin_[i][0]), corner(skin_[i][1]), corner(skin_[i][2]), 0});
    }
  }
  sender_.send(peer, transfer.in_reply_to, message);
}

}  // namespace tissued::daemon
