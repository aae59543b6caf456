#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "core/scene.hpp"
#include "protocol/name.hpp"

namespace tissued::daemon {

/// What a name that the tracker sends stands for.
struct NameEntry {
  enum class Kind : std::uint8_t { unknown, marker, unused_marker, pad, probe, target };
  Kind kind = Kind::unknown;
  int index = -1;  ///< into the scene's list of that kind; -1 for the other kinds
};

/// From names on the wire to indices in the scene. Built at start; a look-up allocates nothing.
class NameTable {
 public:
  /// unused_markers: markers that the tracker knows and the scene does not use.
  /// Throws core::ModelError where a name cannot travel in a datagram, or stands for two things.
  NameTable(const core::Scene& scene, const std::vector<std::string>& unused_markers);

  NameEntry find(const protocol::Name& name) const;

 private:
  void insert(const std::string& name, NameEntry entry);

  std::vector<std::pair<protocol::Name, NameEntry>> entries_;  // ascending by name
};

/// `text` as a name on the wire. Throws core::ModelError that says why it cannot be one.
protocol::Name wire_name(const std::string& text);

}  // namespace tissued::daemon
