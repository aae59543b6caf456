#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/trial.hpp"

namespace tissued::protocol {

/// C3D counts in blocks of this many bytes, from 1.
inline constexpr std::size_t kC3dBlock = 512;

/// The machine whose numbers a C3D file holds; the values are those of the file's fourth parameter byte.
enum class C3dProcessor : std::uint8_t { intel = 84, dec = 85, mips = 86 };

/// The bytes of a C3D file and their numbers. A read past the end is refused with a TrialError that names the byte.
class C3dBytes {
 public:
  C3dBytes(std::span<const std::byte> bytes, std::string file) : bytes_(bytes), file_(std::move(file)) {}

  void set_processor(C3dProcessor processor) { processor_ = processor; }

  std::size_t size() const { return bytes_.size(); }
  const std::string& file() const { return file_; }
  std::uint8_t u8(std::size_t at) const { return static_cast<std::uint8_t>(range(at, 1)[0]); }
  std::uint16_t u16(std::size_t at) const;
  std::int16_t i16(std::size_t at) const { return static_cast<std::int16_t>(u16(at)); }
  float f32(std::size_t at) const;
  std::string_view text(std::size_t at, std::size_t length) const;

  [[noreturn]] void fail(std::size_t at, const std::string& reason) const;

 private:
  std::span<const std::byte> range(std::size_t at, std::size_t count) const;

  std::span<const std::byte> bytes_;
  std::string file_;
  C3dProcessor processor_ = C3dProcessor::intel;
};

/// The parameter section of a C3D file, by group and name in capitals. Values stay in the file's bytes, which must
/// outlive this.
class C3dParameters {
 public:
  /// Reads the section that starts at byte `begin`, and tells `bytes` its processor. Throws TrialError.
  C3dParameters(C3dBytes& bytes, std::size_t begin);

  /// Value `index` of a numeric parameter, integers as unsigned; nothing where there is no such value.
  std::optional<double> number(const char* group, const char* name, std::size_t index = 0) const;
  /// The two words of a count above 65535, such as TRIAL:ACTUAL_END_FIELD: low word first.
  std::optional<std::uint32_t> double_word(const char* group, const char* name) const;
  /// All texts of a parameter, blanks and zeros around them cut off; none where there is no such parameter.
  std::vector<std::string> texts(const char* group, const char* name) const;

 private:
  // Sizes of the elements, too, but for texts.
  enum class Type : std::int8_t { text = -1, byte = 1, integer = 2, real = 4 };
  struct Parameter {
    Type type;
    std::vector<std::uint8_t> dimensions;
    std::size_t at;     // byte of the first value
    std::size_t count;  // of values
  };

  Parameter read_parameter(std::size_t at) const;
  const Parameter* find(const char* group, const char* name) const;

  const C3dBytes& bytes_;
  std::map<std::pair<std::string, std::string>, Parameter> parameters_;
};

}  // namespace tissued::protocol
