#include <cmath>
#include <limits>
#include <set>

#include "protocol/c3d.hpp"
#include "protocol/c3d_parameters.hpp"
#include "protocol/file_content.hpp"
#include "protocol/text_fields.hpp"

namespace tissued::protocol {

namespace {

using Vector = std::array<double, 3>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint32_t kLargestWord = 65535;

// Bytes of the header's words.
constexpr std::size_t kKeyAt = 1;
constexpr std::size_t kPointsAt = 2;
constexpr std::size_t kAnalogAt = 4;  // analog values per frame, all channels and sub frames
constexpr std::size_t kFirstFrameAt = 6;
constexpr std::size_t kLastFrameAt = 8;
constexpr std::size_t kScaleAt = 12;
constexpr std::size_t kDataBlockAt = 16;
constexpr std::size_t kRateAt = 20;

constexpr std::uint8_t kKey = 0x50;

// Where the frames lie, and how a point is stored.
struct Layout {
  std::size_t data = 0;    // byte of the first frame
  std::size_t stride = 0;  // bytes per frame, analog values included
  std::size_t points = 0;
  bool is_float = false;
  double scale = 1.0;  // to mm
};

class C3dReader {
 public:
  C3dReader(std::span<const std::byte> bytes, const std::string& name)
      : bytes_(bytes, name), parameters_(bytes_, parameter_section()) {}

  Trial read() {
    Trial trial;
    trial.file = bytes_.file();
    trial.rate_hz = read_rate();
    const Layout layout = read_layout();
    read_frames(trial, layout);
    read_labels(trial, layout.points);
    read_points(trial, layout);
    return trial;
  }

 private:
  std::size_t parameter_section() const;
  double read_rate() const;
  double read_unit() const;
  Layout read_layout() const;
  void read_frames(Trial& trial, const Layout& layout) const;
  void read_labels(Trial& trial, std::size_t points) const;
  void read_points(Trial& trial, const Layout& layout) const;
  Vector float_point(std::size_t at, double scale) const;
  Vector integer_point(std::size_t at, double scale) const;

  C3dBytes bytes_;
  C3dParameters parameters_;
};

std::size_t C3dReader::parameter_section() const {
  if (bytes_.u8(kKeyAt) != kKey) bytes_.fail(kKeyAt, "not a C3D file: this byte must be 0x50");
  const std::size_t block = bytes_.u8(0);
  if (block < 2) bytes_.fail(0, "the parameters cannot start in block " + std::to_string(block));
  return (block - 1) * kC3dBlock;
}

double C3dReader::read_rate() const {
  const double rate = parameters_.number("POINT", "RATE").value_or(bytes_.f32(kRateAt));
  if (!std::isfinite(rate) || rate <= 0.0) bytes_.fail(kRateAt, "the frame rate is not a positive number");
  return rate;
}

double C3dReader::read_unit() const {
  const auto units = parameters_.texts("POINT", "UNITS");
  if (units.empty() || units[0].empty()) return 1.0;
  const auto scale = millimetres_per(units[0]);
  if (!scale) throw TrialError(bytes_.file(), 0, "POINT:UNITS must be mm, cm or m, not " + in_quotes(units[0]));
  return *scale;
}

// A negative scale means float points, which it does not scale.
Layout C3dReader::read_layout() const {
  Layout layout;
  layout.points = bytes_.u16(kPointsAt);
  const auto used = parameters_.number("POINT", "USED");
  if (used && *used != static_cast<double>(layout.points)) {
    bytes_.fail(kPointsAt, "the header says " + std::to_string(layout.points) + " points, POINT:USED does not");
  }
  if (layout.points == 0) bytes_.fail(kPointsAt, "no points");

  const double scale = parameters_.number("POINT", "SCALE").value_or(bytes_.f32(kScaleAt));
  if (!std::isfinite(scale) || scale == 0.0) bytes_.fail(kScaleAt, "the scale must be a number other than 0");
  layout.is_float = scale < 0.0;
  layout.scale = (layout.is_float ? 1.0 : scale) * read_unit();

  const std::size_t word = layout.is_float ? 4 : 2;
  layout.stride = word * (4 * layout.points + bytes_.u16(kAnalogAt));
  const std::size_t block = bytes_.u16(kDataBlockAt);
  if (block < 2) bytes_.fail(kDataBlockAt, "the data cannot start in block " + std::to_string(block));
  layout.data = (block - 1) * kC3dBlock;
  return layout;
}

// The header counts frames in words; longer takes are counted by TRIAL:ACTUAL_END_FIELD or POINT:LONG_FRAMES.
void C3dReader::read_frames(Trial& trial, const Layout& layout) const {
  std::uint32_t first = bytes_.u16(kFirstFrameAt);
  std::uint32_t last = bytes_.u16(kLastFrameAt);
  const auto actual_first = parameters_.double_word("TRIAL", "ACTUAL_START_FIELD");
  const auto actual_last = parameters_.double_word("TRIAL", "ACTUAL_END_FIELD");
  const double long_frames = parameters_.number("POINT", "LONG_FRAMES").value_or(0.0);
  if (actual_first && actual_last && *actual_last > kLargestWord) {
    first = *actual_first;
    last = *actual_last;
  } else if (long_frames > kLargestWord && long_frames < std::numeric_limits<std::int32_t>::max()) {
    last = first + static_cast<std::uint32_t>(long_frames) - 1;
  }
  if (last < first) {
    bytes_.fail(kFirstFrameAt, "frames " + std::to_string(first) + " to " + std::to_string(last) + " are none");
  }
  if (last > std::numeric_limits<std::int32_t>::max()) bytes_.fail(kLastFrameAt, "the last frame is out of range");
  trial.first_frame = static_cast<int>(first);
  trial.frame_count = std::size_t{last} - first + 1;
  const std::size_t held = bytes_.size() > layout.data ? (bytes_.size() - layout.data) / layout.stride : 0;
  if (trial.frame_count > held) {
    bytes_.fail(layout.data, std::to_string(trial.frame_count) + " frames of " + std::to_string(layout.stride) +
                                 " bytes should start here, the file holds " + std::to_string(held));
  }
}

// Labels stand in LABELS and, beyond 255, in LABELS2, LABELS3 and so on.
void C3dReader::read_labels(Trial& trial, std::size_t points) const {
  std::vector<std::string> names;
  std::vector<std::string> more = parameters_.texts("POINT", "LABELS");
  for (int i = 2; !more.empty() && names.size() < points; ++i) {
    names.insert(names.end(), more.begin(), more.end());
    more = parameters_.texts("POINT", std::string("LABELS").append(std::to_string(i)).c_str());
  }
  names.resize(points);
  std::set<std::string> seen;
  for (std::size_t i = 0; i < points; ++i) {
    if (names[i].empty() || names[i].back() == ':') names[i].append("point ").append(std::to_string(i + 1));
    if (!seen.insert(names[i]).second) {
      throw TrialError(bytes_.file(), 0, "two points are called " + in_quotes(names[i]));
    }
    trial.add_label(names[i]);
  }
}

void C3dReader::read_points(Trial& trial, const Layout& layout) const {
  const std::size_t point_bytes = layout.is_float ? 16 : 8;
  trial.positions.reserve(trial.frame_count * layout.points);
  trial.seen.reserve(trial.frame_count * layout.points);
  for (std::size_t frame = 0; frame < trial.frame_count; ++frame) {
    for (std::size_t p = 0; p < layout.points; ++p) {
      const std::size_t at = layout.data + frame * layout.stride + p * point_bytes;
      const Vector point = layout.is_float ? float_point(at, layout.scale) : integer_point(at, layout.scale);
      const bool seen = std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
      trial.positions.push_back(seen ? point : Vector{kNaN, kNaN, kNaN});
      trial.seen.push_back(seen);
    }
  }
}

// Three coordinates and a fourth word: residual in its low byte, cameras in its high one; negative in a gap.
Vector C3dReader::float_point(std::size_t at, double scale) const {
  if (!(bytes_.f32(at + 12) >= 0.0F)) return {kNaN, kNaN, kNaN};
  return {bytes_.f32(at) * scale, bytes_.f32(at + 4) * scale, bytes_.f32(at + 8) * scale};
}

Vector C3dReader::integer_point(std::size_t at, double scale) const {
  if (bytes_.i16(at + 6) < 0) return {kNaN, kNaN, kNaN};
  return {bytes_.i16(at) * scale, bytes_.i16(at + 2) * scale, bytes_.i16(at + 4) * scale};
}

}  // namespace

Trial parse_c3d(std::span<const std::byte> bytes, const std::string& name) { return C3dReader(bytes, name).read(); }

Trial read_c3d(const std::filesystem::path& path) {
  const std::string content = read_file_content(path);
  return parse_c3d(std::as_bytes(std::span(content)), path.string());
}

}  // namespace tissued::protocol
