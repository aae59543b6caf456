#include "protocol/nexus_block.hpp"

#include <cmath>
#include <limits>
#include <optional>

#include "protocol/text_fields.hpp"

namespace tissued::protocol {

namespace {

using Vector = std::array<double, 3>;
using Cells = std::vector<std::string_view>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Frame and Sub Frame stand before the values of a row.
constexpr std::size_t kFirstValueColumn = 2;

// Three neighbouring columns of a block that are read.
struct Triple {
  std::size_t column;  // of the first component, from 0
  double scale;        // to mm or N
};

class BlockReader {
 public:
  BlockReader(CsvReader& reader, const std::string& file, NexusBlockKind kind)
      : reader_(reader), file_(file), kind_(kind) {}

  NexusBlock read() {
    read_rate();
    read_header();
    read_rows();
    return std::move(block_);
  }

 private:
  [[noreturn]] void fail(int line, const std::string& reason) const { throw TrialError(file_, line, reason); }
  [[noreturn]] void fail(const std::string& reason) const { fail(reader_.line(), reason); }
  [[noreturn]] void fail_cell(int line, std::size_t column, const std::string& reason) const {
    fail(line, std::string("column ").append(std::to_string(column + 1)).append(": ").append(reason));
  }

  // The cells of the next line, blanks behind the last one cut off.
  Cells require_line(const char* what) {
    if (!reader_.next()) fail(std::string("the file ends before ").append(what));
    return {reader_.cells().begin(), reader_.cells().begin() + static_cast<std::ptrdiff_t>(reader_.width())};
  }

  void read_rate();
  void read_header();
  void read_group(std::string_view name, std::size_t begin, std::size_t end);
  double scale_of(std::size_t column) const;
  void read_rows();
  void read_row_number();
  void read_values();
  Vector read_vector(const Triple& triple, std::string_view name) const;
  std::int64_t integer_at(std::size_t column, const char* what) const;
  void check_sub_frames() const;

  CsvReader& reader_;
  const std::string& file_;
  NexusBlockKind kind_;
  NexusBlock block_;
  Cells components_;
  Cells units_;
  std::vector<Triple> triples_;
  std::int64_t sub_frame_ = -1;  // of the current row
};

void BlockReader::read_rate() {
  const Cells cells = require_line("the rate");
  const auto rate = cells.size() == 1 ? parse_number(cells[0]) : std::nullopt;
  if (!rate || *rate <= 0.0) fail("column 1: the line must hold the rate in Hz, a positive number, alone");
  block_.rate_hz = *rate;
}

// The lines of names, components and units.
void BlockReader::read_header() {
  const Cells names = require_line("the names");
  const int names_line = reader_.line();
  components_ = require_line("the components");
  if (components_.size() < kFirstValueColumn || components_[0] != "Frame" || components_[1] != "Sub Frame") {
    fail("column 1: the line of components must start with Frame,Sub Frame");
  }
  units_ = require_line("the units");
  for (std::size_t c = 0; c < names.size(); ++c) {
    if (!names[c].empty() && (c < kFirstValueColumn || c >= components_.size())) {
      fail_cell(names_line, c, in_quotes(names[c]) + " stands over no components");
    }
  }
  std::size_t begin = kFirstValueColumn;
  while (begin < components_.size()) {
    if (begin >= names.size() || names[begin].empty()) fail_cell(names_line, begin, "a name is missing");
    std::size_t end = begin + 1;
    while (end < components_.size() && (end >= names.size() || names[end].empty())) ++end;
    read_group(names[begin], begin, end);
    begin = end;
  }
}

// The columns [begin, end) stand under one name; the reader is at the line of units.
void BlockReader::read_group(std::string_view name, std::size_t begin, std::size_t end) {
  const bool force = kind_ == NexusBlockKind::devices;
  if (force && !name.ends_with(kNexusForceSuffix)) return;
  const std::array<std::string_view, 3> expected =
      force ? std::array<std::string_view, 3>{"Fx", "Fy", "Fz"} : std::array<std::string_view, 3>{"X", "Y", "Z"};
  bool right = end - begin == expected.size();
  for (std::size_t i = 0; right && i < expected.size(); ++i) right = components_[begin + i] == expected[i];
  if (!right) {
    fail_cell(reader_.line() - 1, begin,
              in_quotes(name) + " must have the components " + (force ? "Fx,Fy,Fz" : "X,Y,Z") + " and no others");
  }
  const double scale = scale_of(begin);
  for (std::size_t c = begin + 1; c < end; ++c) {
    if (scale_of(c) != scale) fail_cell(reader_.line(), c, "another unit than that of the first component");
  }
  triples_.push_back({begin, scale});
  block_.names.emplace_back(name);
}

double BlockReader::scale_of(std::size_t column) const {
  const std::string_view unit = column < units_.size() ? units_[column] : std::string_view{};
  if (kind_ == NexusBlockKind::devices) {
    if (unit != "N") fail_cell(reader_.line(), column, "the unit must be N, not " + in_quotes(unit));
    return 1.0;
  }
  const auto scale = millimetres_per(unit);
  if (!scale) fail_cell(reader_.line(), column, "the unit must be mm, cm or m, not " + in_quotes(unit));
  return *scale;
}

void BlockReader::read_rows() {
  while (reader_.next() && reader_.width() > 0) {
    const std::size_t width = components_.size();
    if (reader_.width() > width || reader_.cells().size() < width) {
      fail(std::to_string(reader_.cells().size()) + " cells where the header has " + std::to_string(width));
    }
    read_row_number();
    if (sub_frame_ == 0) read_values();
    block_.last_line = reader_.line();
  }
  if (block_.frame_count == 0) fail("a block without a row");
  check_sub_frames();
}

// Frames run from the first one by one, sub frames from 0 in each.
void BlockReader::read_row_number() {
  const std::int64_t frame = integer_at(0, "Frame");
  const std::int64_t sub_frame = integer_at(1, "Sub Frame");
  if (block_.frame_count == 0) {
    if (frame < 0 || frame > std::numeric_limits<int>::max()) fail_cell(reader_.line(), 0, "Frame is out of range");
    if (sub_frame != 0) fail_cell(reader_.line(), 1, "the first Sub Frame must be 0");
    block_.first_frame = frame;
  } else if (sub_frame == 0) {
    if (frame != block_.last_frame() + 1) {
      fail_cell(reader_.line(), 0, "Frame must be " + std::to_string(block_.last_frame() + 1));
    }
    check_sub_frames();
  } else if (frame != block_.last_frame() || sub_frame != sub_frame_ + 1) {
    fail_cell(reader_.line(), 1,
              "Sub Frame must be " + std::to_string(sub_frame_ + 1) + " of frame " +
                  std::to_string(block_.last_frame()) + ", or 0 of the next");
  }
  sub_frame_ = sub_frame;
  if (sub_frame == 0) ++block_.frame_count;
  if (block_.frame_count == 1) block_.sub_frames = static_cast<int>(sub_frame) + 1;
}

// The frame that ends before or with the current row must have had as many rows as the first one.
void BlockReader::check_sub_frames() const {
  if (sub_frame_ + 1 == block_.sub_frames) return;
  fail("frame " + std::to_string(block_.last_frame()) + " has " + std::to_string(sub_frame_ + 1) +
       " sub frames, the first one has " + std::to_string(block_.sub_frames));
}

void BlockReader::read_values() {
  for (std::size_t i = 0; i < triples_.size(); ++i) {
    block_.values.push_back(read_vector(triples_[i], block_.names[i]));
  }
}

Vector BlockReader::read_vector(const Triple& triple, std::string_view name) const {
  Vector vector{kNaN, kNaN, kNaN};
  std::size_t empty = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t column = triple.column + i;
    const std::string_view text = reader_.cell(column);
    if (text.empty()) {
      ++empty;
      continue;
    }
    vector[i] = parse_number(text).value_or(kNaN) * triple.scale;
    if (!std::isfinite(vector[i])) {
      fail_cell(reader_.line(), column,
                std::string(name) + " " + std::string(components_[column]) + ": " + in_quotes(text) +
                    " is not a finite number");
    }
  }
  if (empty == 1 || empty == 2) {
    fail_cell(reader_.line(), triple.column, std::string(name) + ": some of its three cells are empty, others are not");
  }
  return vector;
}

std::int64_t BlockReader::integer_at(std::size_t column, const char* what) const {
  const auto value = parse_integer(reader_.cell(column));
  if (!value) {
    fail_cell(reader_.line(), column,
              std::string(what) + ": " + in_quotes(reader_.cell(column)) + " is not an integer");
  }
  return *value;
}

}  // namespace

NexusBlock read_nexus_block(CsvReader& reader, const std::string& file, NexusBlockKind kind) {
  return BlockReader(reader, file, kind).read();
}

}  // namespace tissued::protocol
