#include "daemon/introduction.hpp"

#include <algorithm>
#include <cstdint>
#include <string>

#include "daemon/counters.hpp"
#include "daemon/name_table.hpp"
#include "daemon/version.hpp"

namespace tissued::daemon {

namespace {

using protocol::NameKind;

std::size_t place_of(NameKind kind) { return static_cast<std::size_t>(kind); }

// For people to read: what does not fit into a name is cut off.
protocol::Name shown_name(const std::string& text) {
  std::string printable = text.substr(0, protocol::Name::kCapacity);
  std::replace_if(
      printable.begin(), printable.end(), [](char c) { return c < 0x20 || c > 0x7E; }, '?');
  return protocol::Name::from(printable.empty() ? "?" : printable).value_or(protocol::Name{});
}

template <typename Items>
std::vector<protocol::Name> names_of(const Items& items) {
  std::vector<protocol::Name> names;
  for (const auto& item : items) names.push_back(wire_name(item.name));
  return names;
}

protocol::HelloReply introduce(const config::DaemonConfig& config, const core::Scene& scene) {
  protocol::HelloReply hello;
  hello.version = shown_name(kVersion);
  hello.model = shown_name(scene.name);
  hello.simulator = shown_name(config.simulator.kind);
  hello.units = shown_name("mm s N");
  hello.nominal_rate_hz = scene.rate;
  hello.node_count = static_cast<std::uint32_t>(scene.mesh.node_count());
  hello.tetrahedron_count = static_cast<std::uint32_t>(scene.mesh.tet_count());
  hello.triangle_count = static_cast<std::uint32_t>(scene.mesh.find_surface(scene.skin_surface)->triangles.size());
  hello.target_count = static_cast<std::uint16_t>(scene.targets.size());
  hello.marker_count = static_cast<std::uint16_t>(scene.markers.size());
  hello.pad_count = static_cast<std::uint16_t>(scene.pads.size());
  return hello;
}

}  // namespace

Introduction::Introduction(const config::DaemonConfig& config, const core::Scene& scene)
    : hello_(introduce(config, scene)) {
  names_[place_of(NameKind::target)] = names_of(scene.targets);
  names_[place_of(NameKind::marker)] = names_of(scene.markers);
  names_[place_of(NameKind::pad)] = names_of(scene.pads);
  names_[place_of(NameKind::probe)] = names_of(scene.probes);
  for (std::size_t i = 0; i < Counters::kSize; ++i)
    names_[place_of(NameKind::counter)].push_back(shown_name(Counters::name(i)));
}

void Introduction::for_each_part(NameKind kind, const std::function<void(const protocol::Names&)>& take) const {
  const std::vector<protocol::Name>& table = names_[place_of(kind)];
  protocol::Names part;
  part.kind = kind;
  part.total = static_cast<std::uint16_t>(table.size());
  std::size_t next = 0;
  do {
    part.first = static_cast<std::uint16_t>(next);
    part.names.clear();
    while (next < table.size() && part.names.push_back(table[next])) ++next;
    take(part);
  } while (next < table.size());
}

}  // namespace tissued::daemon
