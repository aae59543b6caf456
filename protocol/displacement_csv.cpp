#include "protocol/displacement_csv.hpp"

#include <stdexcept>

#include "protocol/csv_reader.hpp"
#include "protocol/file_content.hpp"
#include "protocol/text_fields.hpp"

namespace tissued::protocol {

namespace {

constexpr std::array<std::string_view, 6> kColumns{"x", "y", "z", "ux", "uy", "uz"};
constexpr std::string_view kHeader = "x,y,z,ux,uy,uz\n";

void require_header(CsvReader& reader, const std::string& name) {
  const bool any = reader.next();
  bool right = any && reader.width() == kColumns.size();
  for (std::size_t i = 0; right && i < kColumns.size(); ++i) right = reader.cell(i) == kColumns[i];
  if (!right) throw FileError(name, any ? 1 : 0, "the table must start with the line x,y,z,ux,uy,uz");
}

}  // namespace

DisplacementTable parse_displacement_csv(std::string_view text, const std::string& name) {
  CsvReader reader(text);
  require_header(reader, name);
  DisplacementTable table;
  while (reader.next()) {
    if (reader.width() == 0) continue;
    if (reader.width() != kColumns.size()) {
      throw FileError(name, reader.line(), std::to_string(reader.width()) + " cells where 6 should be");
    }
    std::array<double, 6> row{};
    for (std::size_t i = 0; i < row.size(); ++i) {
      const auto value = parse_number(reader.cell(i));
      if (!value) {
        throw FileError(name, reader.line(),
                        "column " + std::to_string(i + 1) + " (" + std::string(kColumns[i]) +
                            "): " + in_quotes(reader.cell(i)) + " is not a finite number");
      }
      row[i] = *value;
    }
    table.rest.push_back({row[0], row[1], row[2]});
    table.displacement.push_back({row[3], row[4], row[5]});
  }
  return table;
}

DisplacementTable read_displacement_csv(const std::filesystem::path& path) {
  return parse_displacement_csv(read_file_content(path), path.string());
}

std::string format_displacement_csv(const DisplacementTable& table) {
  if (table.rest.size() != table.displacement.size()) {
    throw std::invalid_argument("a displacement table needs as many displacements as rest positions");
  }
  std::string text(kHeader);
  for (std::size_t i = 0; i < table.rest.size(); ++i) {
    for (const double value : table.rest[i]) {
      append_number(text, value);
      text += ',';
    }
    for (const double value : table.displacement[i]) {
      append_number(text, value);
      text += ',';
    }
    text.back() = '\n';
  }
  return text;
}

void write_displacement_csv(const DisplacementTable& table, const std::filesystem::path& path) {
  write_file_content(path, format_displacement_csv(table));
}

}  // namespace tissued::protocol
