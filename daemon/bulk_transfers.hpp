#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/scene.hpp"
#include "daemon/answer.hpp"
#include "daemon/counters.hpp"
#include "daemon/message_sender.hpp"
#include "daemon/peer_table.hpp"

namespace tissued::daemon {

/// Sends what needs many datagrams, node positions and cells, a few chunks a millisecond and in turn to all who asked:
/// predictions must not wait behind a mesh, nor a receiver's buffer overflow.
class BulkTransfers {
 public:
  enum class Content : std::uint8_t { mesh_float32, mesh_float64, tetrahedra, skin_triangles };

  /// on_mesh_idle: called when the last transfer of node positions has ended. References must outlive this.
  BulkTransfers(boost::asio::io_context& context, const core::Scene& scene, PeerTable& peers, MessageSender& sender,
                Counters& counters, std::function<void()> on_mesh_idle);

  /// Begins to send, the first chunks at once. mesh: needed for node positions; it must not change until
  /// mesh_under_way() is false again. A transfer of the same content to the same client that is still on its way goes
  /// on, and this one is refused and counted.
  void begin(Peer& peer, Content content, std::uint32_t in_reply_to, const MeshSnapshot* mesh);

  bool mesh_under_way() const { return mesh_transfers_ > 0; }

 private:
  struct Transfer {
    boost::asio::ip::udp::endpoint endpoint;
    Content content;
    std::uint32_t in_reply_to;
    std::size_t next_chunk;
    std::size_t chunk_count;
  };

  static bool is_mesh(Content content) { return content == Content::mesh_float32 || content == Content::mesh_float64; }
  std::size_t chunk_count(Content content) const;
  void send_some();
  bool send_chunk(Transfer& transfer);
  void send_positions(Peer& peer, const Transfer& transfer);
  void send_cells(Peer& peer, const Transfer& transfer);
  void pause();

  boost::asio::steady_timer pause_;
  const core::Scene& scene_;
  const std::vector<core::Triangle>& skin_;
  PeerTable& peers_;
  MessageSender& sender_;
  Counters& counters_;
  std::function<void()> on_mesh_idle_;
  const MeshSnapshot* mesh_ = nullptr;
  std::vector<Transfer> transfers_;
  std::size_t mesh_transfers_ = 0;
  bool pausing_ = false;
};

}  // namespace tissued::daemon
