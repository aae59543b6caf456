#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "daemon/parameter_search.hpp"

namespace tissued::daemon {

/// Everything that a search has evaluated, in a file that is complete after every batch. A search without chance but
/// its seed's asks for the same points again when it is begun again, and is told what the file knows: so it goes on
/// where it was, and ends where it would have without the interruption, to the bit.
class EvaluationTrace {
 public:
  /// heading: one line with all that the values depend on. Reads the file where there is one; throws UsageError where
  /// it has another heading, std::runtime_error where it cannot be read.
  EvaluationTrace(std::filesystem::path path, std::string heading, const std::vector<VariedKey>& keys);

  /// The values at `points`; those that are not known are asked of `objective` at once, then written. Throws
  /// std::runtime_error where the file cannot be written.
  std::vector<double> evaluate(const std::vector<SearchPoint>& points, const SearchObjective& objective);

  std::size_t count() const { return rows_.size(); }
  /// In the order in which they were evaluated.
  const std::vector<SearchResult>& rows() const { return rows_; }

 private:
  void add(const SearchPoint& point, double value);
  void read();
  void write() const;

  std::filesystem::path path_;
  std::string heading_, columns_;
  std::size_t width_;
  std::vector<SearchResult> rows_;
  std::map<SearchPoint, double> known_;
};

}  // namespace tissued::daemon
