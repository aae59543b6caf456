#include "protocol/vicon_stream.hpp"

#include <algorithm>
#include <cmath>

#include "protocol/bytes.hpp"

namespace tissued::protocol {

namespace {

constexpr std::size_t kBlockHeaderSize = 5;                                       // frame number, items in block
constexpr std::size_t kItemHeaderSize = 3;                                        // item id, item data size
constexpr std::size_t kPartCountOffset = kBlockHeaderSize + kItemHeaderSize + 9;  // the stamp item goes first

constexpr std::uint16_t kObjectSize = Name::kCapacity + 48;
constexpr std::uint16_t kMarkerSize = Name::kCapacity + 25;
constexpr std::uint16_t kForceSize = Name::kCapacity + 24;
constexpr std::uint16_t kTruthSize = Name::kCapacity + 24;
constexpr std::uint16_t kStampSize = 10;

constexpr std::uint8_t kOccludedFlag = 0x01;

// No datagram can hold more items of a kind than its list, so a decoder's push_back cannot fail.
constexpr std::size_t most_items(std::size_t data_size) {
  return (kMaxTrackerDatagram - kBlockHeaderSize) / (kItemHeaderSize + data_size);
}
static_assert(most_items(kObjectSize) <= decltype(TrackerDatagram::objects)::kCapacity);
static_assert(most_items(kMarkerSize) <= decltype(TrackerDatagram::markers)::kCapacity);
static_assert(most_items(kForceSize) <= decltype(TrackerDatagram::forces)::kCapacity);
static_assert(most_items(kTruthSize) <= decltype(TrackerDatagram::truth)::kCapacity);

// The number gates, not-finite before magnitude.
TrackerRefusal judge(const std::array<double, 3>& values, double limit) {
  if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) {
    return TrackerRefusal::not_finite;
  }
  if (!std::all_of(values.begin(), values.end(), [=](double v) { return std::abs(v) <= limit; })) {
    return TrackerRefusal::absurd_magnitude;
  }
  return TrackerRefusal::none;
}

TrackerRefusal judge(const TrackedObject& object) {
  const TrackerRefusal position = judge(object.position, kMaxPosition);
  const TrackerRefusal rotation = judge(object.rotation_rad, kMaxRotation_rad);
  if (position == TrackerRefusal::none) return rotation;
  return rotation == TrackerRefusal::not_finite ? rotation : position;
}

TrackerRefusal read_name(ByteReader& reader, Name& name) {
  const auto read = Name::from_padded(reader.bytes(Name::kCapacity));
  if (!read) return TrackerRefusal::bad_name;
  name = *read;
  return TrackerRefusal::none;
}

TrackerRefusal read_object(ByteReader data, TrackerDatagram& datagram) {
  TrackedObject object;
  if (read_name(data, object.name) != TrackerRefusal::none) return TrackerRefusal::bad_name;
  object.position = data.vector();
  object.rotation_rad = data.vector();
  datagram.objects.push_back(object);
  return judge(object);
}

TrackerRefusal read_marker(ByteReader data, TrackerDatagram& datagram) {
  TrackedMarker marker;
  if (read_name(data, marker.name) != TrackerRefusal::none) return TrackerRefusal::bad_name;
  marker.position = data.vector();
  const std::uint8_t flags = data.u8();
  if ((flags & ~kOccludedFlag) != 0) return TrackerRefusal::bad_flags;
  marker.occluded = (flags & kOccludedFlag) != 0;
  datagram.markers.push_back(marker);
  return judge(marker.position, kMaxPosition);
}

TrackerRefusal read_force(ByteReader data, TrackerDatagram& datagram) {
  PadForce force;
  if (read_name(data, force.name) != TrackerRefusal::none) return TrackerRefusal::bad_name;
  force.force = data.vector();
  datagram.forces.push_back(force);
  return judge(force.force, kMaxForce);
}

TrackerRefusal read_truth(ByteReader data, TrackerDatagram& datagram) {
  TargetTruth truth;
  if (read_name(data, truth.name) != TrackerRefusal::none) return TrackerRefusal::bad_name;
  truth.position = data.vector();
  datagram.truth.push_back(truth);
  return judge(truth.position, kMaxPosition);
}

TrackerRefusal read_stamp(ByteReader data, TrackerDatagram& datagram) {
  FrameStamp stamp;
  stamp.stamp_ns = data.u64();
  stamp.part = data.u8();
  stamp.part_count = data.u8();
  if (stamp.part >= stamp.part_count) return TrackerRefusal::bad_stamp;
  if (datagram.stamp) return TrackerRefusal::repeated_stamp;
  datagram.stamp = stamp;
  return TrackerRefusal::none;
}

struct KnownItem {
  ItemId id;
  std::size_t data_size;
  TrackerRefusal (*read)(ByteReader data, TrackerDatagram& datagram);
};

constexpr std::array<KnownItem, 5> kKnownItems{{
    {ItemId::object, kObjectSize, read_object},
    {ItemId::marker, kMarkerSize, read_marker},
    {ItemId::force, kForceSize, read_force},
    {ItemId::truth, kTruthSize, read_truth},
    {ItemId::stamp, kStampSize, read_stamp},
}};

TrackerRefusal read_item(std::uint8_t id, std::span<const std::uint8_t> data, TrackerDatagram& datagram) {
  for (const KnownItem& known : kKnownItems) {
    if (id != static_cast<std::uint8_t>(known.id)) continue;
    if (data.size() != known.data_size) return TrackerRefusal::wrong_item_size;
    return known.read(ByteReader(data), datagram);
  }
  ++datagram.skipped_items;
  return TrackerRefusal::none;
}

void clear(TrackerDatagram& datagram) {
  datagram.frame_number = 0;
  datagram.stamp.reset();
  datagram.objects.clear();
  datagram.markers.clear();
  datagram.forces.clear();
  datagram.truth.clear();
  datagram.skipped_items = 0;
}

// Spreads items over packets, opening the next one where an item does not fit.
class FrameWriter {
 public:
  FrameWriter(const TrackerFrame& frame, std::span<TrackerPacket> packets)
      : frame_number_(frame.frame_number), stamp_ns_(frame.stamp_ns), packets_(packets) {
    open_packet();
  }

  void add(const TrackedObject& object) {
    accept(judge(object));
    begin_item(ItemId::object, kObjectSize, object.name);
    writer_.vector(object.position);
    writer_.vector(object.rotation_rad);
  }

  void add(const TrackedMarker& marker) {
    // Whatever stands in an occluded marker's position, nothing of it goes out.
    const auto position = marker.occluded ? std::array<double, 3>{} : marker.position;
    accept(judge(position, kMaxPosition));
    begin_item(ItemId::marker, kMarkerSize, marker.name);
    writer_.vector(position);
    writer_.u8(marker.occluded ? kOccludedFlag : 0);
  }

  void add(const PadForce& force) {
    accept(judge(force.force, kMaxForce));
    begin_item(ItemId::force, kForceSize, force.name);
    writer_.vector(force.force);
  }

  void add(const TargetTruth& truth) {
    accept(judge(truth.position, kMaxPosition));
    begin_item(ItemId::truth, kTruthSize, truth.name);
    writer_.vector(truth.position);
  }

  std::size_t finish() {
    close_packet();
    if (!ok_) return 0;
    if (stamp_ns_) {
      for (TrackerPacket& packet : packets_.first(count_)) {
        packet.bytes[kPartCountOffset] = static_cast<std::uint8_t>(count_);
      }
    }
    return count_;
  }

 private:
  void accept(TrackerRefusal refusal) { ok_ = ok_ && refusal == TrackerRefusal::none; }

  void begin_item(ItemId id, std::uint16_t data_size, const Name& name) {
    if (writer_.remaining() < kItemHeaderSize + data_size) {
      close_packet();
      open_packet();
    }
    ok_ = ok_ && !name.empty();
    write_item_header(id, data_size);
    writer_.bytes(name.padded());
  }

  void write_item_header(ItemId id, std::uint16_t data_size) {
    writer_.u8(static_cast<std::uint8_t>(id));
    writer_.u16(data_size);
    ++items_;
  }

  void open_packet() {
    if (!ok_ || count_ == packets_.size() || count_ == 255) {
      ok_ = false;
      writer_ = ByteWriter({});
      return;
    }
    writer_ = ByteWriter(packets_[count_].bytes);
    items_ = 0;
    writer_.u32(frame_number_);
    writer_.u8(0);  // items in block: close_packet knows
    if (!stamp_ns_) return;
    write_item_header(ItemId::stamp, kStampSize);
    writer_.u64(*stamp_ns_);
    writer_.u8(static_cast<std::uint8_t>(count_));
    writer_.u8(0);  // part count: finish knows
  }

  void close_packet() {
    ok_ = ok_ && writer_.ok();
    if (!ok_) return;
    TrackerPacket& packet = packets_[count_++];
    packet.size = writer_.size();
    packet.bytes[kBlockHeaderSize - 1] = items_;
  }

  std::uint32_t frame_number_;
  std::optional<std::uint64_t> stamp_ns_;
  std::span<TrackerPacket> packets_;
  ByteWriter writer_{{}};
  std::size_t count_ = 0;   // packets closed
  std::uint8_t items_ = 0;  // in the open packet; 1024 bytes hold far fewer than 255
  bool ok_ = true;
};

}  // namespace

const char* to_string(TrackerRefusal refusal) {
  switch (refusal) {
    case TrackerRefusal::none:
      return "none";
    case TrackerRefusal::too_short:
      return "too_short";
    case TrackerRefusal::too_long:
      return "too_long";
    case TrackerRefusal::truncated_item:
      return "truncated_item";
    case TrackerRefusal::wrong_item_size:
      return "wrong_item_size";
    case TrackerRefusal::bad_name:
      return "bad_name";
    case TrackerRefusal::bad_flags:
      return "bad_flags";
    case TrackerRefusal::bad_stamp:
      return "bad_stamp";
    case TrackerRefusal::repeated_stamp:
      return "repeated_stamp";
    case TrackerRefusal::not_finite:
      return "not_finite";
    case TrackerRefusal::absurd_magnitude:
      return "absurd_magnitude";
    case TrackerRefusal::trailing_bytes:
      return "trailing_bytes";
  }
  return "unknown";
}

TrackerRefusal decode_tracker_datagram(std::span<const std::uint8_t> bytes, TrackerDatagram& datagram) {
  clear(datagram);
  if (bytes.size() < kBlockHeaderSize) return TrackerRefusal::too_short;
  if (bytes.size() > kMaxTrackerDatagram) return TrackerRefusal::too_long;
  ByteReader reader(bytes);
  datagram.frame_number = reader.u32();
  const std::uint8_t items_in_block = reader.u8();
  for (int item = 0; item < items_in_block; ++item) {
    const std::uint8_t id = reader.u8();
    const std::uint16_t data_size = reader.u16();
    const auto data = reader.bytes(data_size);
    if (!reader.ok()) return TrackerRefusal::truncated_item;
    const TrackerRefusal refusal = read_item(id, data, datagram);
    if (refusal != TrackerRefusal::none) return refusal;
  }
  // Tracker sends blocks of a fixed size (256, 512 or 1024 bytes) whatever they hold.
  const auto padding = reader.bytes(reader.remaining());
  const bool zero = std::all_of(padding.begin(), padding.end(), [](std::uint8_t byte) { return byte == 0; });
  return zero ? TrackerRefusal::none : TrackerRefusal::trailing_bytes;
}

std::size_t encode_tracker_frame(const TrackerFrame& frame, std::span<TrackerPacket> packets) {
  FrameWriter writer(frame, packets);
  for (const TrackedObject& object : frame.objects) writer.add(object);
  for (const TrackedMarker& marker : frame.markers) writer.add(marker);
  for (const PadForce& force : frame.forces) writer.add(force);
  for (const TargetTruth& truth : frame.truth) writer.add(truth);
  return writer.finish();
}

}  // namespace tissued::protocol
