#include "daemon/name_table.hpp"

#include <algorithm>
#include <string>

namespace tissued::daemon {

namespace {

bool before(const std::pair<protocol::Name, NameEntry>& entry, std::string_view name) {
  return entry.first.view() < name;
}

}  // namespace

protocol::Name wire_name(const std::string& text) {
  const auto name = protocol::Name::from(text);
  if (!name) {
    throw core::ModelError("name '" + text + "' cannot travel in a datagram: 1 to 24 printable ASCII characters can");
  }
  return *name;
}

NameTable::NameTable(const core::Scene& scene, const std::vector<std::string>& unused_markers) {
  using Kind = NameEntry::Kind;
  for (std::size_t i = 0; i < scene.markers.size(); ++i)
    insert(scene.markers[i].name, {Kind::marker, static_cast<int>(i)});
  for (std::size_t i = 0; i < scene.pads.size(); ++i) insert(scene.pads[i].name, {Kind::pad, static_cast<int>(i)});
  for (std::size_t i = 0; i < scene.probes.size(); ++i)
    insert(scene.probes[i].name, {Kind::probe, static_cast<int>(i)});
  for (std::size_t i = 0; i < scene.targets.size(); ++i)
    insert(scene.targets[i].name, {Kind::target, static_cast<int>(i)});
  for (const auto& name : unused_markers) insert(name, {Kind::unused_marker, -1});
}

void NameTable::insert(const std::string& name, NameEntry entry) {
  const auto place = std::lower_bound(entries_.begin(), entries_.end(), std::string_view(name), before);
  if (place != entries_.end() && place->first.view() == name) {
    throw core::ModelError("name '" + name + "' stands for two things among markers, pads, probes and targets");
  }
  entries_.insert(place, {wire_name(name), entry});
}

NameEntry NameTable::find(const protocol::Name& name) const {
  const auto place = std::lower_bound(entries_.begin(), entries_.end(), name.view(), before);
  return place != entries_.end() && place->first == name ? place->second : NameEntry{};
}

}  // namespace tissued::daemon
