#include "daemon/recording_reader.hpp"

#include <numeric>
#include <stdexcept>

#include "daemon/session_recorder.hpp"
#include "protocol/file_content.hpp"

namespace tissued::daemon {

RecordingReader::RecordingReader(const std::filesystem::path& file) {
  std::vector<std::filesystem::path> files{file};
  for (std::uint64_t n = 2; std::filesystem::exists(part_of_recording(file, n)); ++n)
    files.push_back(part_of_recording(file, n));
  if (std::filesystem::exists(part_of_recording(file, files.size() + 2)))
    throw std::runtime_error(part_of_recording(file, files.size() + 1).string() + ": is missing of the recording");
  for (const auto& part : files) contents_.push_back(protocol::read_file_content(part));
  for (std::size_t i = 0; i < files.size(); ++i) {
    const protocol::SessionReader& reader = readers_.emplace_back(protocol::bytes_of(contents_[i]));
    if (i > 0 && i + 1 == files.size() && reader.refusal() == protocol::SessionRefusal::too_short) {
      readers_.pop_back();
      torn_ = true;
      break;
    }
    if (reader.refusal() != protocol::SessionRefusal::none)
      throw std::runtime_error(files[i].string() + ": not a recording of tissued: " + to_string(reader.refusal()));
    if (reader.header().monotonic_ns != header().monotonic_ns || reader.header().wall_ns != header().wall_ns)
      throw std::runtime_error(files[i].string() + ": belongs to another recording than " + file.string());
  }
  // It is what a recording begins with.
  protocol::SessionReader beginning(protocol::bytes_of(contents_.front()));
  for (auto record = beginning.next(); record && record->kind == protocol::SessionRecordKind::configuration;
       record = beginning.next())
    configuration_.append(record->body.begin(), record->body.end());
}

std::optional<protocol::SessionRecord> RecordingReader::next() {
  using protocol::SessionRecordKind;
  for (; part_ < readers_.size(); ++part_) {
    while (const auto record = readers_[part_].next()) {
      if (record->kind != SessionRecordKind::configuration && record->kind != SessionRecordKind::part) return record;
    }
  }
  return std::nullopt;
}

std::size_t RecordingReader::damaged_bytes() const {
  return std::accumulate(readers_.begin(), readers_.end(), std::size_t{0},
                         [](std::size_t sum, const auto& reader) { return sum + reader.damaged_bytes(); });
}

}  // namespace tissued::daemon
