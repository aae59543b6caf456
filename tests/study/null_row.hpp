// One null and what became of it: a row of the study's CSV.
#pragma once

#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "tests/study/null_session.hpp"

namespace tissued::study {

struct NullRow {
  std::uint64_t seed = 0;
  std::map<std::string, std::string> cells;  // by the names of columns()

  // NaN where the cell is empty.
  double number(const std::string& column) const;
  const std::string& text(const std::string& column) const { return cells.at(column); }
};

const std::vector<std::string>& columns();

// Draws the null and diagnoses it, on one thread and for as long as it takes. The same for the same seed but for the
// columns of seconds.
NullRow study_null(std::uint64_t seed);

void write_header(std::ostream& out);
void write_row(const NullRow& row, std::ostream& out);
// Throws std::runtime_error where the file has other columns; a last line that was cut off is left out.
std::vector<NullRow> read_rows(const std::string& file);

}  // namespace tissued::study
