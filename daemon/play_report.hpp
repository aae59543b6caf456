#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/duration_sample.hpp"
#include "daemon/target_errors.hpp"

namespace tissued::daemon {

/// What playing some trials showed, as a table or as JSON.
class PlayReport {
 public:
  explicit PlayReport(std::vector<std::string> targets) : targets_(std::move(targets)) {}

  void add(const std::string& trial, const PlayedTrial& played, const std::vector<TargetError>& errors);

  /// `watched`: answers were asked for; without them there are only frames sent.
  std::string text(bool watched) const;
  nlohmann::json json() const;

  std::size_t sent() const;
  std::size_t answered() const;

 private:
  struct Row {
    std::string trial;
    std::size_t sent;
    std::size_t answered;
    std::map<std::string, std::size_t> validity;  // frames, by the word for it
    std::vector<TargetError> errors;
  };
  std::vector<TargetError> mean_errors() const;
  std::vector<std::string> error_cells(const std::vector<TargetError>& errors) const;

  std::vector<std::string> targets_;
  std::vector<Row> rows_;
  DurationSample receive_to_send_, step_, round_trip_;
  double innovation_square_sum_ = 0.0;  // mm^2
  std::size_t innovations_ = 0;
};

}  // namespace tissued::daemon
