#include "protocol/csv_reader.hpp"

#include "protocol/text_fields.hpp"

namespace tissued::protocol {

CsvReader::CsvReader(std::string_view text) : rest_(text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
}

bool CsvReader::next() {
  cells_.clear();
  width_ = 0;
  if (rest_.empty()) return false;
  const std::size_t length = rest_.find('\n');
  std::string_view text = rest_.substr(0, length);
  rest_.remove_prefix(length == std::string_view::npos ? rest_.size() : length + 1);
  ++line_;
  for (bool more = true; more;) {
    const std::size_t comma = text.find(',');
    more = comma != std::string_view::npos;
    cells_.push_back(trimmed(text.substr(0, comma)));
    if (!cells_.back().empty()) width_ = cells_.size();
    if (more) text.remove_prefix(comma + 1);
  }
  return true;
}

}  // namespace tissued::protocol
