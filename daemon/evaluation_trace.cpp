#include "daemon/evaluation_trace.hpp"

#include <fstream>
#include <sstream>
#include <system_error>

#include "daemon/ctl_options.hpp"
#include "protocol/text_fields.hpp"

namespace tissued::daemon {
EvaluationTrace::EvaluationTrace(std::filesystem::path path, std::string heading, const std::vector<VariedKey>& keys)
    : path_(std::move(path)), heading_("# " + std::move(heading)), columns_("objective_mm"), width_(keys.size()) {
  for (const VariedKey& key : keys) columns_ += "," + key.key;
  if (std::filesystem::exists(path_)) read();
}

void EvaluationTrace::read() {
  std::ifstream file(path_);
  std::string line;
  if (!file) throw std::runtime_error(path_.string() + ": cannot be read");
  if (!std::getline(file, line) || line != heading_ || !std::getline(file, line) || line != columns_) {
    throw UsageError(path_.string() + " is of another search, which this one cannot go on with; choose another --out");
  }
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::vector<double> numbers;
    for (std::string cell; std::getline(cells, cell, ',');) {
      const auto number = protocol::parse_number(cell);
      if (!number) throw std::runtime_error(path_.string() + ": `" + cell + "` is not a number");
      numbers.push_back(*number);
    }
    if (numbers.size() != width_ + 1) throw std::runtime_error(path_.string() + ": `" + line + "` is not a row");
    add({numbers.begin() + 1, numbers.end()}, numbers.front());
  }
}

void EvaluationTrace::add(const SearchPoint& point, double value) {
  rows_.push_back({point, value});
  known_[point] = value;
}

// Beside the file and then in its place: whenever the program ends, one of the two is whole.
void EvaluationTrace::write() const {
  const std::filesystem::path beside = path_.string() + ".new";
  std::ofstream file(beside);
  file << heading_ << '\n' << columns_ << '\n';
  for (const SearchResult& row : rows_) {
    std::string line;
    protocol::append_number(line, row.value);
    for (const double number : row.point) protocol::append_number(line += ',', number);
    file << line << '\n';
  }
  file.close();
  std::error_code failed;
  if (file) std::filesystem::rename(beside, path_, failed);
  if (!file || failed) throw std::runtime_error(path_.string() + ": cannot be written");
}

std::vector<double> EvaluationTrace::evaluate(const std::vector<SearchPoint>& points,
                                              const SearchObjective& objective) {
  std::vector<SearchPoint> unknown;
  for (const SearchPoint& point : points)
    if (!known_.contains(point)) unknown.push_back(point);
  if (!unknown.empty()) {
    const std::vector<double> values = objective(unknown);
    for (std::size_t i = 0; i < unknown.size(); ++i) add(unknown[i], values[i]);
    write();
  }
  std::vector<double> all;
  for (const SearchPoint& point : points) all.push_back(known_.at(point));
  return all;
}

}  // namespace tissued::daemon
