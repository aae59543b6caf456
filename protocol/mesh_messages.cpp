#include "protocol/mesh_messages.hpp"

#include <algorithm>
#include <span>

namespace tissued::protocol {

namespace {

bool is_cell_kind(CellKind kind) { return kind == CellKind::tetrahedron || kind == CellKind::skin_triangle; }

// Whether chunk `chunk` of a table of `total` entries begins and ends where the layout says.
bool chunk_in_place(std::size_t chunk, std::size_t chunks, std::size_t first, std::size_t count, std::size_t total,
                    std::size_t per_chunk) {
  return chunk < chunks && chunks == chunk_count(total, per_chunk) && first == chunk * per_chunk &&
         count == std::min(per_chunk, total - first);
}

std::array<double, 3> read_position(ByteReader& reader, Precision precision) {
  if (precision == Precision::float64) return reader.vector();
  const float x = reader.f32();
  const float y = reader.f32();
  const float z = reader.f32();
  return {x, y, z};
}

void write_position(ByteWriter& writer, Precision precision, const std::array<double, 3>& position) {
  if (precision == Precision::float64) {
    writer.vector(position);
    return;
  }
  for (const double component : position) writer.f32(static_cast<float>(component));
}

std::size_t corner_count(CellKind kind) { return kind == CellKind::skin_triangle ? 3 : 4; }

std::array<std::uint32_t, 4> read_cell(ByteReader& reader, CellKind kind) {
  std::array<std::uint32_t, 4> cell{};
  for (std::uint32_t& node : std::span(cell).first(corner_count(kind))) node = reader.u32();
  return cell;
}

ClientRefusal value_gate(bool good) { return good ? ClientRefusal::none : ClientRefusal::bad_value; }

}  // namespace

bool is_precision(Precision precision) { return precision == Precision::float32 || precision == Precision::float64; }

ClientRefusal read_body(ByteReader& reader, QueryMesh& message) {
  message.precision = static_cast<Precision>(reader.u8());
  return value_gate(is_precision(message.precision));
}

void write_body(ByteWriter& writer, const QueryMesh& message) {
  writer.u8(static_cast<std::uint8_t>(message.precision));
}

ClientRefusal read_body(ByteReader& reader, QueryTopology& message) {
  message.kind = static_cast<CellKind>(reader.u8());
  return value_gate(is_cell_kind(message.kind));
}

void write_body(ByteWriter& writer, const QueryTopology& message) {
  writer.u8(static_cast<std::uint8_t>(message.kind));
}

ClientRefusal read_body(ByteReader& reader, MeshPositions& message) {
  message.tracker_frame = reader.u32();
  message.chunk = reader.u16();
  message.chunk_count = reader.u16();
  message.receive_ns = reader.u64();
  message.send_ns = reader.u64();
  message.node_total = reader.u32();
  message.first_node = reader.u32();
  const std::uint8_t count = reader.u8();
  message.precision = static_cast<Precision>(reader.u8());
  const bool reserved_zero = reader.u16() == 0;
  if (!message.positions.resize(count)) return ClientRefusal::wrong_size;
  for (auto& position : message.positions) position = read_position(reader, message.precision);
  return value_gate(is_precision(message.precision) && reserved_zero &&
                    chunk_in_place(message.chunk, message.chunk_count, message.first_node, count, message.node_total,
                                   nodes_per_chunk(message.precision)));
}

void write_body(ByteWriter& writer, const MeshPositions& message) {
  writer.u32(message.tracker_frame);
  writer.u16(message.chunk);
  writer.u16(message.chunk_count);
  writer.u64(message.receive_ns);
  writer.u64(message.send_ns);
  writer.u32(message.node_total);
  writer.u32(message.first_node);
  writer.u8(static_cast<std::uint8_t>(message.positions.size()));
  writer.u8(static_cast<std::uint8_t>(message.precision));
  writer.u16(0);
  for (const auto& position : message.positions) write_position(writer, message.precision, position);
}

ClientRefusal read_body(ByteReader& reader, MeshCells& message) {
  message.kind = static_cast<CellKind>(reader.u8());
  const std::uint8_t count = reader.u8();
  bool good = reader.u16() == 0;
  message.chunk = reader.u16();
  message.chunk_count = reader.u16();
  message.node_total = reader.u32();
  message.cell_total = reader.u32();
  message.first_cell = reader.u32();
  if (!message.cells.resize(count)) return ClientRefusal::wrong_size;
  for (auto& cell : message.cells) {
    cell = read_cell(reader, message.kind);
    const auto corners = std::span(cell).first(corner_count(message.kind));
    good = good && std::all_of(corners.begin(), corners.end(), [&](auto node) { return node < message.node_total; });
  }
  return value_gate(good && is_cell_kind(message.kind) &&
                    chunk_in_place(message.chunk, message.chunk_count, message.first_cell, count, message.cell_total,
                                   cells_per_chunk(message.kind)));
}

void write_body(ByteWriter& writer, const MeshCells& message) {
  writer.u8(static_cast<std::uint8_t>(message.kind));
  writer.u8(static_cast<std::uint8_t>(message.cells.size()));
  writer.u16(0);
  writer.u16(message.chunk);
  writer.u16(message.chunk_count);
  writer.u32(message.node_total);
  writer.u32(message.cell_total);
  writer.u32(message.first_cell);
  for (const auto& cell : message.cells) {
    for (const std::uint32_t node : std::span(cell).first(corner_count(message.kind))) writer.u32(node);
  }
}

}  // namespace tissued::protocol
