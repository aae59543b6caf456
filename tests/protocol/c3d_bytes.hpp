#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tissued::tests {

enum class Machine { intel = 84, dec = 85, mips = 86 };

// C3D files put together byte by byte from the format's manual, not by our writer; any part can be made wrong.
class C3dFile {
 public:
  explicit C3dFile(Machine machine = Machine::intel) : machine_(machine) {}

  // The header's fields.
  int points = 0;
  int analog_per_frame = 0;
  int first_frame = 1;
  int last_frame = 1;
  float scale = -1.0F;
  float rate = 100.0F;
  int parameter_blocks = 1;

  void group(int id, const std::string& name) {
    append_name(parameters_, name, -id);
    append_word(parameters_, 2 + 1 + 4);
    append_byte(parameters_, 4);
    parameters_ += "some";
  }

  void text(int group, const std::string& name, int width, const std::vector<std::string>& values) {
    std::string bytes;
    for (const std::string& value : values) {
      bytes += value;
      bytes.append(static_cast<std::size_t>(width) - value.size(), ' ');
    }
    parameter(group, name, -1, {width, static_cast<int>(values.size())}, bytes);
  }

  void words(int group, const std::string& name, const std::vector<int>& values, bool scalar = false) {
    std::string bytes;
    for (const int value : values) append_word(bytes, value);
    parameter(group, name, 2, scalar ? std::vector<int>{} : std::vector<int>{static_cast<int>(values.size())}, bytes);
  }

  void real(int group, const std::string& name, float value) {
    std::string bytes;
    append_float(bytes, value);
    parameter(group, name, 4, {}, bytes);
  }

  void parameter(int group, const std::string& name, int type, const std::vector<int>& dimensions,
                 const std::string& values) {
    append_name(parameters_, name, group);
    append_word(parameters_, static_cast<int>(2 + 2 + dimensions.size() + values.size() + 1 + 2));
    append_byte(parameters_, type);
    append_byte(parameters_, static_cast<int>(dimensions.size()));
    for (const int dimension : dimensions) append_byte(parameters_, dimension);
    parameters_ += values;
    append_byte(parameters_, 2);
    parameters_ += "of";
  }

  // One float point: coordinates and the fourth word.
  void point(float x, float y, float z, float fourth) {
    for (const float value : {x, y, z, fourth}) append_float(data_, value);
  }
  // One integer point.
  void integer_point(int x, int y, int z, int fourth) {
    for (const int value : {x, y, z, fourth}) append_word(data_, value);
  }
  void analog(float value) { append_float(data_, value); }
  void integer_analog(int value) { append_word(data_, value); }

  // A usual POINT group, as group 1.
  void usual_parameters(const std::vector<std::string>& labels, const std::string& unit = "mm") {
    group(1, "POINT");
    words(1, "USED", {points}, true);
    real(1, "SCALE", scale);
    real(1, "RATE", rate);
    text(1, "UNITS", 4, {unit});
    text(1, "LABELS", 16, labels);
  }

  std::string content() const {
    std::string bytes;
    append_byte(bytes, 2);
    append_byte(bytes, 0x50);
    append_word(bytes, points);
    append_word(bytes, analog_per_frame);
    append_word(bytes, first_frame);
    append_word(bytes, last_frame);
    append_word(bytes, 10);
    append_float(bytes, scale);
    append_word(bytes, 2 + parameter_blocks);
    append_word(bytes, 1);
    append_float(bytes, rate);
    bytes.resize(512, '\0');
    bytes += std::string("\0\0", 2);
    append_byte(bytes, parameter_blocks);
    append_byte(bytes, static_cast<int>(machine_));
    bytes += parameters_;
    bytes.resize(512 * static_cast<std::size_t>(1 + parameter_blocks), '\0');
    return bytes + data_;
  }

 private:
  static void append_byte(std::string& bytes, int value) { bytes += static_cast<char>(value & 0xFF); }

  void append_word(std::string& bytes, int value) const {
    append_byte(bytes, machine_ == Machine::mips ? value >> 8 : value);
    append_byte(bytes, machine_ == Machine::mips ? value : value >> 8);
  }

  // Intel: little-endian IEEE. MIPS: big-endian IEEE. DEC: four times the value, its two words exchanged.
  void append_float(std::string& bytes, float value) const {
    const auto bits = std::bit_cast<std::uint32_t>(machine_ == Machine::dec ? 4.0F * value : value);
    const auto low = static_cast<int>(bits & 0xFFFFU);
    const auto high = static_cast<int>(bits >> 16);
    append_word(bytes, machine_ == Machine::intel ? low : high);
    append_word(bytes, machine_ == Machine::intel ? high : low);
  }

  // A negative length is a locked name.
  static void append_name(std::string& bytes, const std::string& name, int id) {
    const auto length = static_cast<int>(name.size());
    append_byte(bytes, name == "LABELS" ? -length : length);
    append_byte(bytes, id);
    bytes += name;
  }

  Machine machine_;
  std::string parameters_;
  std::string data_;
};

// Two points in three frames of float numbers, with a gap, and five analog values a frame.
inline C3dFile small_c3d_file(Machine machine) {
  C3dFile file(machine);
  file.points = 2;
  file.analog_per_frame = 5;
  file.first_frame = 11;
  file.last_frame = 13;
  file.usual_parameters({"body:one", "two"});
  for (int frame = 0; frame < 3; ++frame) {
    const auto f = static_cast<float>(frame);
    file.point(1.0F + f, -2.5F, 0.03125F, 32519.0F);
    file.point(7.0F, 8.0F, 9.0F + f, frame == 1 ? -1.0F : 0.0F);
    for (int i = 0; i < 5; ++i) file.analog(1e6F);
  }
  return file;
}

inline std::span<const std::byte> as_bytes(const std::string& content) { return std::as_bytes(std::span(content)); }

}  // namespace tissued::tests
