#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "protocol/c3d.hpp"
#include "protocol/c3d_parameters.hpp"
#include "protocol/file_content.hpp"
#include "protocol/text_fields.hpp"

namespace tissued::protocol {

namespace {

constexpr std::size_t kLargestWord = 65535;
constexpr std::size_t kLargestDimension = 255;
// 255 labels of this length are what the offset to the next parameter can still reach over.
constexpr std::size_t kLongestLabel = 127;
// The size of a unit, where points are float the sign alone matters.
constexpr float kFloatPoints = -1.0F;
constexpr int kPointGroup = 1;
constexpr int kTrialGroup = 2;

std::uint16_t word(std::size_t value) { return static_cast<std::uint16_t>(std::min(value, kLargestWord)); }

// Little-endian fields one after the other.
class Bytes {
 public:
  void u8(std::size_t value) { content_ += static_cast<char>(static_cast<unsigned char>(value)); }
  void u16(std::size_t value) {
    u8(value & 0xFFU);
    u8(value >> 8 & 0xFFU);
  }
  void u32(std::size_t value) {
    u16(value & 0xFFFFU);
    u16(value >> 16);
  }
  void f32(float value) { u32(std::bit_cast<std::uint32_t>(value)); }
  void text(const std::string& value, std::size_t width) {
    content_ += value;
    content_.append(width - value.size(), ' ');
  }
  void fill_to(std::size_t size) { content_.resize(size, '\0'); }
  // Fills up the last block.
  void end_block() { fill_to((content_.size() + kC3dBlock - 1) / kC3dBlock * kC3dBlock); }

  std::string& content() { return content_; }
  std::size_t size() const { return content_.size(); }

 private:
  std::string content_;
};

// `<length> <id> <name> <offset to the next> <description>`; a group has the negative id of its parameters.
void append_group(Bytes& bytes, int id, const std::string& name) {
  bytes.u8(name.size());
  bytes.u8(static_cast<std::size_t>(256 - id));
  bytes.text(name, name.size());
  bytes.u16(3);
  bytes.u8(0);
}

// `<length> <id> <name> <offset to the next> <type> <dimensions> <values> <description>`
void append_parameter(Bytes& bytes, int id, const std::string& name, int type,
                      const std::vector<std::size_t>& dimensions, Bytes values) {
  bytes.u8(name.size());
  bytes.u8(static_cast<std::size_t>(id));
  bytes.text(name, name.size());
  bytes.u16(2 + 1 + 1 + dimensions.size() + values.size() + 1);
  bytes.u8(static_cast<std::size_t>(type < 0 ? 256 + type : type));
  bytes.u8(dimensions.size());
  for (const std::size_t dimension : dimensions) bytes.u8(dimension);
  bytes.content() += values.content();
  bytes.u8(0);
}

void append_word(Bytes& bytes, int id, const std::string& name, std::size_t value) {
  Bytes values;
  values.u16(value);
  append_parameter(bytes, id, name, 2, {}, std::move(values));
}

void append_double_word(Bytes& bytes, int id, const std::string& name, std::size_t value) {
  Bytes values;
  values.u32(value);
  append_parameter(bytes, id, name, 2, {2}, std::move(values));
}

void append_float(Bytes& bytes, int id, const std::string& name, float value) {
  Bytes values;
  values.f32(value);
  append_parameter(bytes, id, name, 4, {}, std::move(values));
}

// LABELS, LABELS2 and so on, 255 each, padded to the longest.
void append_labels(Bytes& bytes, const Trial& trial) {
  std::size_t width = 1;
  for (std::size_t i = 0; i < trial.labels.size(); ++i) width = std::max(width, trial.full_label(i).size());
  for (std::size_t first = 0; first < trial.labels.size(); first += kLargestDimension) {
    const std::size_t count = std::min(kLargestDimension, trial.labels.size() - first);
    Bytes values;
    for (std::size_t i = first; i < first + count; ++i) values.text(trial.full_label(i), width);
    std::string name = "LABELS";
    if (first > 0) name += std::to_string(first / kLargestDimension + 1);
    append_parameter(bytes, kPointGroup, name, -1, {width, count}, std::move(values));
  }
}

// The whole section but for its block count and where the data start, which depend on its size.
Bytes parameter_list(const Trial& trial, std::size_t data_block) {
  const std::size_t last_frame = static_cast<std::size_t>(trial.first_frame) + trial.frame_count - 1;
  Bytes bytes;
  append_group(bytes, kPointGroup, "POINT");
  append_word(bytes, kPointGroup, "USED", trial.labels.size());
  append_word(bytes, kPointGroup, "FRAMES", word(trial.frame_count));
  append_word(bytes, kPointGroup, "DATA_START", data_block);
  append_float(bytes, kPointGroup, "SCALE", kFloatPoints);
  append_float(bytes, kPointGroup, "RATE", static_cast<float>(trial.rate_hz));
  Bytes unit;
  unit.text("mm", 2);
  append_parameter(bytes, kPointGroup, "UNITS", -1, {2, 1}, std::move(unit));
  append_labels(bytes, trial);
  append_group(bytes, kTrialGroup, "TRIAL");
  append_double_word(bytes, kTrialGroup, "ACTUAL_START_FIELD", static_cast<std::size_t>(trial.first_frame));
  append_double_word(bytes, kTrialGroup, "ACTUAL_END_FIELD", last_frame);
  bytes.u8(0);
  return bytes;
}

void append_header(Bytes& bytes, const Trial& trial, std::size_t data_block) {
  const auto first = static_cast<std::size_t>(trial.first_frame);
  bytes.u8(2);
  bytes.u8(0x50);
  bytes.u16(trial.labels.size());
  bytes.u16(0);
  bytes.u16(word(first));
  bytes.u16(word(first + trial.frame_count - 1));
  bytes.u16(0);
  bytes.f32(kFloatPoints);
  bytes.u16(data_block);
  bytes.u16(0);
  bytes.f32(static_cast<float>(trial.rate_hz));
  bytes.end_block();
}

void append_points(Bytes& bytes, const Trial& trial) {
  for (std::size_t i = 0; i < trial.positions.size(); ++i) {
    for (const double value : trial.positions[i]) bytes.f32(trial.seen[i] ? static_cast<float>(value) : 0.0F);
    bytes.f32(trial.seen[i] ? 0.0F : -1.0F);
  }
}

void require_writable(const Trial& trial) {
  if (trial.labels.empty() || trial.labels.size() > kLargestWord) {
    throw std::invalid_argument("a C3D file holds 1 to 65535 points, not " + std::to_string(trial.labels.size()));
  }
  if (trial.frame_count == 0 || trial.first_frame < 0) {
    throw std::invalid_argument("a C3D file holds one frame or more, numbered from 0 or above");
  }
  for (std::size_t i = 0; i < trial.labels.size(); ++i) {
    const std::string label = trial.full_label(i);
    if (label.empty() || label.size() > kLongestLabel) {
      throw std::invalid_argument("a C3D file cannot hold the label " + in_quotes(label));
    }
  }
}

}  // namespace

std::string format_c3d(const Trial& trial) {
  require_writable(trial);
  const std::size_t blocks = (4 + parameter_list(trial, 0).size() + kC3dBlock - 1) / kC3dBlock;
  if (blocks > kLargestDimension) throw std::invalid_argument("the labels do not fit the parameters of a C3D file");
  const std::size_t data_block = 2 + blocks;

  Bytes bytes;
  append_header(bytes, trial, data_block);
  bytes.u8(1);
  bytes.u8(0x50);
  bytes.u8(blocks);
  bytes.u8(static_cast<std::size_t>(C3dProcessor::intel));
  bytes.content() += parameter_list(trial, data_block).content();
  bytes.end_block();
  append_points(bytes, trial);
  bytes.end_block();
  return std::move(bytes.content());
}

void write_c3d(const Trial& trial, const std::filesystem::path& path) { write_file_content(path, format_c3d(trial)); }

}  // namespace tissued::protocol
