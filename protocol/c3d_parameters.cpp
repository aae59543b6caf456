#include "protocol/c3d_parameters.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "protocol/text_fields.hpp"

namespace tissued::protocol {

namespace {

std::string capitals(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return out;
}

// The F format of the VAX: sign, 8 bits of exponent to the base 128, mantissa 0.1f in binary.
float from_vax(std::uint32_t bits) {
  const int exponent = static_cast<int>(bits >> 23 & 0xFFU);
  const bool negative = bits >> 31 != 0;
  if (exponent == 0) return negative ? std::numeric_limits<float>::quiet_NaN() : 0.0F;
  const double magnitude = std::ldexp(static_cast<double>((bits & 0x7FFFFFU) | 0x800000U), exponent - 128 - 24);
  return static_cast<float>(negative ? -magnitude : magnitude);
}

}  // namespace

std::span<const std::byte> C3dBytes::range(std::size_t at, std::size_t count) const {
  if (at > bytes_.size() || bytes_.size() - at < count) {
    throw TrialError(file_, 0,
                     "the file is cut off: byte " + std::to_string(at) + " is needed, the file has " +
                         std::to_string(bytes_.size()));
  }
  return bytes_.subspan(at, count);
}

std::uint16_t C3dBytes::u16(std::size_t at) const {
  const auto pair = range(at, 2);
  const auto first = static_cast<unsigned>(pair[0]);
  const auto second = static_cast<unsigned>(pair[1]);
  return static_cast<std::uint16_t>(processor_ == C3dProcessor::mips ? first << 8 | second : second << 8 | first);
}

float C3dBytes::f32(std::size_t at) const {
  const std::uint32_t first = u16(at);
  const std::uint32_t second = u16(at + 2);
  switch (processor_) {
    case C3dProcessor::mips:
      return std::bit_cast<float>(first << 16 | second);
    case C3dProcessor::dec:
      return from_vax(first << 16 | second);
    case C3dProcessor::intel:
      break;
  }
  return std::bit_cast<float>(second << 16 | first);
}

std::string_view C3dBytes::text(std::size_t at, std::size_t length) const {
  const auto bytes = range(at, length);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void C3dBytes::fail(std::size_t at, const std::string& reason) const {
  throw TrialError(file_, 0, std::string("byte ").append(std::to_string(at)).append(": ").append(reason));
}

// A section starts with two bytes of no meaning, the number of its blocks and the processor; then come groups and
// parameters in any order, each `<length of name> <id> <name> <offset to the next, from here> ...`. A negative length
// means locked, a negative id a group. The list ends with a length of 0, an offset of 0 or the section.
C3dParameters::C3dParameters(C3dBytes& bytes, std::size_t begin) : bytes_(bytes) {
  const std::size_t blocks = bytes.u8(begin + 2);
  const auto processor = static_cast<C3dProcessor>(bytes.u8(begin + 3));
  if (processor != C3dProcessor::intel && processor != C3dProcessor::dec && processor != C3dProcessor::mips) {
    bytes.fail(begin + 3,
               "processor " + std::to_string(bytes.u8(begin + 3)) + " is none of 84 (Intel), 85 (DEC), 86 (MIPS)");
  }
  bytes.set_processor(processor);

  std::map<int, std::string> groups;
  std::vector<std::pair<int, std::pair<std::string, Parameter>>> found;  // by group id
  const std::size_t end = blocks == 0 ? bytes.size() : std::min(bytes.size(), begin + blocks * kC3dBlock);
  std::size_t at = begin + 4;
  while (at < end) {
    const auto length = static_cast<std::size_t>(std::abs(static_cast<std::int8_t>(bytes.u8(at))));
    if (length == 0) break;
    const int id = static_cast<std::int8_t>(bytes.u8(at + 1));
    const std::string name = capitals(trimmed(bytes.text(at + 2, length)));
    const std::size_t offset_at = at + 2 + length;
    const std::size_t offset = bytes.u16(offset_at);
    if (id < 0) groups[-id] = name;
    if (id > 0) found.push_back({id, {name, read_parameter(offset_at + 2)}});
    if (offset == 0) break;
    at = offset_at + offset;
  }
  for (auto& [id, parameter] : found) {
    parameters_.emplace(std::pair{groups[id], std::move(parameter.first)}, std::move(parameter.second));
  }
}

// `<type> <number of dimensions> <dimensions> <values>`
C3dParameters::Parameter C3dParameters::read_parameter(std::size_t at) const {
  Parameter parameter{static_cast<Type>(bytes_.u8(at)), {}, 0, 1};
  if (parameter.type != Type::text && parameter.type != Type::byte && parameter.type != Type::integer &&
      parameter.type != Type::real) {
    bytes_.fail(at, "a parameter of the unknown type " + std::to_string(static_cast<int>(parameter.type)));
  }
  const std::size_t dimensions = bytes_.u8(at + 1);
  parameter.at = at + 2 + dimensions;
  for (std::size_t i = 0; i < dimensions; ++i) {
    parameter.dimensions.push_back(bytes_.u8(at + 2 + i));
    parameter.count *= parameter.dimensions.back();
    // Stops the product of hostile dimensions before it overflows.
    if (parameter.count > bytes_.size()) bytes_.fail(at + 2 + i, "a parameter larger than the file");
  }
  bytes_.text(parameter.at, parameter.count * std::abs(static_cast<int>(parameter.type)));
  return parameter;
}

const C3dParameters::Parameter* C3dParameters::find(const char* group, const char* name) const {
  const auto parameter = parameters_.find({group, name});
  return parameter == parameters_.end() ? nullptr : &parameter->second;
}

std::optional<double> C3dParameters::number(const char* group, const char* name, std::size_t index) const {
  const Parameter* parameter = find(group, name);
  if (parameter == nullptr || index >= parameter->count) return std::nullopt;
  switch (parameter->type) {
    case Type::byte:
      return bytes_.u8(parameter->at + index);
    case Type::integer:
      return bytes_.u16(parameter->at + 2 * index);
    case Type::real:
      return bytes_.f32(parameter->at + 4 * index);
    case Type::text:
      break;
  }
  return std::nullopt;
}

std::optional<std::uint32_t> C3dParameters::double_word(const char* group, const char* name) const {
  const Parameter* parameter = find(group, name);
  if (parameter == nullptr || parameter->type != Type::integer || parameter->count < 2) return std::nullopt;
  return std::uint32_t{bytes_.u16(parameter->at + 2)} << 16 | bytes_.u16(parameter->at);
}

std::vector<std::string> C3dParameters::texts(const char* group, const char* name) const {
  const Parameter* parameter = find(group, name);
  if (parameter == nullptr || parameter->type != Type::text || parameter->count == 0) return {};
  const std::size_t length = parameter->dimensions.empty() ? 1 : parameter->dimensions[0];
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < parameter->count / length; ++i) {
    const std::string_view padded = bytes_.text(parameter->at + i * length, length);
    texts.emplace_back(trimmed(padded.substr(0, padded.find('\0'))));
  }
  return texts;
}

}  // namespace tissued::protocol
