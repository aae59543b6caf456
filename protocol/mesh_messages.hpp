#pragma once

#include <array>
#include <cstdint>

#include "protocol/client_header.hpp"
#include "protocol/fixed_list.hpp"

// The mesh: where its nodes are, and once per session how they are joined.

namespace tissued::protocol {

// How node positions travel.
enum class Precision : std::uint8_t { float32 = 4, float64 = 8 };

bool is_precision(Precision precision);

// Asks for the newest node positions; answered by MeshPositions, all its chunks.
struct QueryMesh {
  static constexpr MessageType kType = MessageType::query_mesh;
  Precision precision = Precision::float32;
};

enum class CellKind : std::uint8_t { tetrahedron = 4, skin_triangle = 3 };  // the value is the number of corners

// Asks for the mesh's cells of one kind; answered by MeshCells, all its chunks.
struct QueryTopology {
  static constexpr MessageType kType = MessageType::query_topology;
  CellKind kind = CellKind::tetrahedron;
};

// One chunk of the node positions at one tracker frame: nodes chunk * nodes_per_chunk(precision) and up. Every chunk
// but the last is full, so each can be placed by itself. All of one frame have the same tracker_frame and receive_ns.
struct MeshPositions {
  static constexpr MessageType kType = MessageType::mesh_positions;
  std::uint32_t tracker_frame = 0;
  std::uint64_t receive_ns = 0;  // daemon's clock: first datagram of the tracker frame
  std::uint64_t send_ns = 0;     // daemon's clock: this datagram
  std::uint16_t chunk = 0;       // 0 .. chunk_count - 1
  std::uint16_t chunk_count = 1;
  std::uint32_t node_total = 0;  // of the mesh
  std::uint32_t first_node = 0;  // index of positions[0]
  Precision precision = Precision::float32;
  FixedList<std::array<double, 3>, 110> positions;  // mm, tracker frame; 110 at float32, 55 at float64
};

constexpr std::size_t nodes_per_chunk(Precision precision) { return precision == Precision::float32 ? 110 : 55; }

// One chunk of the cells: cells chunk * cells_per_chunk(kind) and up; every chunk but the last is full.
struct MeshCells {
  static constexpr MessageType kType = MessageType::mesh_cells;
  CellKind kind = CellKind::tetrahedron;
  std::uint16_t chunk = 0;
  std::uint16_t chunk_count = 1;
  std::uint32_t node_total = 0;  // every corner is below it
  std::uint32_t cell_total = 0;
  std::uint32_t first_cell = 0;
  FixedList<std::array<std::uint32_t, 4>, 112> cells;  // node indices; a triangle leaves the fourth 0
};

constexpr std::size_t cells_per_chunk(CellKind kind) { return kind == CellKind::tetrahedron ? 84 : 112; }

// ceil(total / per_chunk), and 1 where there is nothing: an empty table is answered too.
constexpr std::size_t chunk_count(std::size_t total, std::size_t per_chunk) {
  return total == 0 ? 1 : (total + per_chunk - 1) / per_chunk;
}

ClientRefusal read_body(ByteReader& reader, QueryMesh& message);
ClientRefusal read_body(ByteReader& reader, QueryTopology& message);
ClientRefusal read_body(ByteReader& reader, MeshPositions& message);
ClientRefusal read_body(ByteReader& reader, MeshCells& message);
void write_body(ByteWriter& writer, const QueryMesh& message);
void write_body(ByteWriter& writer, const QueryTopology& message);
void write_body(ByteWriter& writer, const MeshPositions& message);
void write_body(ByteWriter& writer, const MeshCells& message);

}  // namespace tissued::protocol
