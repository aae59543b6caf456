#include "protocol/nexus_csv.hpp"

#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "protocol/csv_reader.hpp"
#include "protocol/file_content.hpp"
#include "protocol/nexus_block.hpp"
#include "protocol/text_fields.hpp"

namespace tissued::protocol {

namespace {

void skip_block(CsvReader& reader) {
  while (reader.next() && reader.width() > 0) {
  }
}

void check_trajectories(const NexusBlock& block, const std::string& file) {
  if (block.sub_frames != 1) {
    throw TrialError(file, block.last_line, "trajectories with " + std::to_string(block.sub_frames) + " sub frames");
  }
  std::set<std::string_view> seen;
  for (const std::string& name : block.names) {
    if (name.ends_with(':')) throw TrialError(file, 0, "a trajectory " + in_quotes(name) + " without a label");
    if (!seen.insert(name).second) throw TrialError(file, 0, "two trajectories are called " + in_quotes(name));
  }
}

void check_devices(const NexusBlock& devices, const NexusBlock& trajectories, const std::string& file) {
  if (std::abs(devices.rate_hz - devices.sub_frames * trajectories.rate_hz) > 1e-6 * devices.rate_hz) {
    throw TrialError(file, devices.last_line,
                     "devices at " + std::to_string(devices.rate_hz) + " Hz with " +
                         std::to_string(devices.sub_frames) + " rows a frame do not go with trajectories at " +
                         std::to_string(trajectories.rate_hz) + " Hz");
  }
  if (devices.first_frame != trajectories.first_frame || devices.frame_count != trajectories.frame_count) {
    const bool devices_short = devices.last_frame() < trajectories.last_frame();
    throw TrialError(file, devices_short ? devices.last_line : trajectories.last_line,
                     "devices hold frames " + std::to_string(devices.first_frame) + " to " +
                         std::to_string(devices.last_frame()) + ", trajectories " +
                         std::to_string(trajectories.first_frame) + " to " + std::to_string(trajectories.last_frame()));
  }
}

Trial joined(NexusBlock trajectories, std::optional<NexusBlock> devices, const std::string& file) {
  Trial trial;
  trial.file = file;
  trial.rate_hz = trajectories.rate_hz;
  trial.first_frame = static_cast<int>(trajectories.first_frame);
  trial.frame_count = trajectories.frame_count;
  for (const std::string& name : trajectories.names) trial.add_label(name);
  trial.positions = std::move(trajectories.values);
  trial.seen.reserve(trial.positions.size());
  for (const auto& position : trial.positions) trial.seen.push_back(!std::isnan(position[0]));
  if (devices) {
    for (const std::string& name : devices->names) {
      trial.devices.push_back(name.substr(0, name.size() - kNexusForceSuffix.size()));
    }
    trial.forces = std::move(devices->values);
  }
  return trial;
}

// A name that a cell can hold and that reads back as itself.
void require_writable(const std::string& name) {
  if (name.empty() || name.find_first_of(",\n\r") != std::string::npos || trimmed(name) != name) {
    throw std::invalid_argument("a Nexus export cannot hold the name " + in_quotes(name));
  }
}

void append_header(std::string& text, const char* title, double rate_hz, const std::vector<std::string>& names,
                   const char* components, const char* units) {
  text.append(title).append("\n");
  append_number(text, rate_hz);
  text += "\n,";
  for (const std::string& name : names) {
    require_writable(name);
    text.append(",").append(name).append(",,");
  }
  text += "\nFrame,Sub Frame";
  for (std::size_t i = 0; i < names.size(); ++i) text.append(",").append(components);
  text += "\n,";
  for (std::size_t i = 0; i < names.size(); ++i) text.append(",").append(units);
  text += '\n';
}

void append_vector(std::string& text, const std::array<double, 3>& vector, bool present) {
  for (const double value : vector) {
    text += ',';
    if (present) append_number(text, value);
  }
}

void append_devices(std::string& text, const Trial& trial) {
  std::vector<std::string> names;
  for (const std::string& device : trial.devices) names.push_back(device + std::string(kNexusForceSuffix));
  append_header(text, "Devices", trial.rate_hz, names, "Fx,Fy,Fz", "N,N,N");
  for (std::size_t frame = 0; frame < trial.frame_count; ++frame) {
    text.append(std::to_string(trial.first_frame + static_cast<std::int64_t>(frame))).append(",0");
    for (std::size_t d = 0; d < trial.devices.size(); ++d) {
      append_vector(text, trial.force(frame, d), !std::isnan(trial.force(frame, d)[0]));
    }
    text += '\n';
  }
  text += '\n';
}

void append_trajectories(std::string& text, const Trial& trial) {
  std::vector<std::string> names;
  for (std::size_t l = 0; l < trial.labels.size(); ++l) names.push_back(trial.full_label(l));
  append_header(text, "Trajectories", trial.rate_hz, names, "X,Y,Z", "mm,mm,mm");
  for (std::size_t frame = 0; frame < trial.frame_count; ++frame) {
    text.append(std::to_string(trial.first_frame + static_cast<std::int64_t>(frame))).append(",0");
    for (std::size_t l = 0; l < trial.labels.size(); ++l) {
      append_vector(text, trial.position(frame, l), trial.is_seen(frame, l));
    }
    text += '\n';
  }
}

}  // namespace

Trial parse_nexus_csv(std::string_view text, const std::string& name) {
  CsvReader reader(text);
  std::optional<NexusBlock> devices;
  std::optional<NexusBlock> trajectories;
  while (reader.next()) {
    if (reader.width() == 0) continue;
    const std::string_view title = reader.cell(0);
    if (reader.width() > 1 || parse_number(title)) {
      throw TrialError(name, reader.line(), "column 1: the title of a block, such as Trajectories, should be here");
    }
    auto* block = title == "Devices" ? &devices : title == "Trajectories" ? &trajectories : nullptr;
    if (block == nullptr) {
      skip_block(reader);
      continue;
    }
    if (*block) throw TrialError(name, reader.line(), "a second block " + in_quotes(title));
    *block = read_nexus_block(reader, name, block == &devices ? NexusBlockKind::devices : NexusBlockKind::trajectories);
  }
  if (!trajectories) throw TrialError(name, 0, "no block Trajectories");
  check_trajectories(*trajectories, name);
  if (devices) check_devices(*devices, *trajectories, name);
  return joined(*std::move(trajectories), std::move(devices), name);
}

Trial read_nexus_csv(const std::filesystem::path& path) {
  return parse_nexus_csv(read_file_content(path), path.string());
}

std::string format_nexus_csv(const Trial& trial) {
  std::string text;
  if (!trial.devices.empty()) append_devices(text, trial);
  append_trajectories(text, trial);
  return text;
}

void write_nexus_csv(const Trial& trial, const std::filesystem::path& path) {
  write_file_content(path, format_nexus_csv(trial));
}

}  // namespace tissued::protocol
