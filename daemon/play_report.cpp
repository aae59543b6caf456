#include "daemon/play_report.hpp"

#include <cmath>
#include <limits>
#include <numeric>

#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

// JSON has no NaN: what could not be compared is null.
nlohmann::json number_or_null(double value) { return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(); }

std::string latency_line(const char* name, const DurationSample& sample) {
  return pad_to(name, 16, false) + "p50 " + fixed(sample.percentile_ms(0.5), 2) + "  p99 " +
         fixed(sample.percentile_ms(0.99), 2) + "  max " + fixed(sample.max_ms(), 2) + " ms\n";
}

nlohmann::json latency_json(const DurationSample& sample) {
  return {{"p50", sample.percentile_ms(0.5)}, {"p99", sample.percentile_ms(0.99)}, {"max", sample.max_ms()}};
}

nlohmann::json errors_json(const std::vector<TargetError>& errors) {
  nlohmann::json json = nlohmann::json::object();
  for (const TargetError& error : errors) {
    json[error.name] = {{"hold_mm", number_or_null(error.hold_mm)}, {"rms_mm", number_or_null(error.rms_mm)}};
  }
  return json;
}

std::vector<std::string> joined(std::initializer_list<std::vector<std::string>> lists) {
  std::vector<std::string> all;
  for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

}  // namespace

void PlayReport::add(const std::string& trial, const PlayedTrial& played, const std::vector<TargetError>& errors) {
  Row row{trial, played.sent, played.answered, {}, errors};
  for (const auto& found : played.answers) {
    if (!found) continue;
    const protocol::Predictions& frame = found->answer.frame;
    ++row.validity[protocol::to_string(frame.validity)];
    receive_to_send_.add(frame.send_ns - frame.receive_ns);
    step_.add(frame.step_time_ns);
    round_trip_.add(found->round_trip_ns);
    if (frame.markers_used == 0) continue;
    innovation_square_sum_ += frame.innovation_rms * frame.innovation_rms;
    ++innovations_;
  }
  rows_.push_back(std::move(row));
}

std::size_t PlayReport::sent() const {
  return std::accumulate(rows_.begin(), rows_.end(), std::size_t{0}, [](auto n, const Row& r) { return n + r.sent; });
}

std::size_t PlayReport::answered() const {
  return std::accumulate(rows_.begin(), rows_.end(), std::size_t{0},
                         [](auto n, const Row& r) { return n + r.answered; });
}

std::vector<TargetError> PlayReport::mean_errors() const {
  std::vector<TargetError> means;
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    std::vector<TargetError> column;
    for (const Row& row : rows_) column.push_back(row.errors[t]);
    means.push_back({targets_[t], mean_hold_mm(column), mean_rms_mm(column), column.size()});
  }
  return means;
}

std::vector<std::string> PlayReport::error_cells(const std::vector<TargetError>& errors) const {
  std::vector<std::string> cells;
  for (const TargetError& error : errors) cells.push_back(fixed(error.hold_mm, 3));
  if (!errors.empty()) {
    cells.push_back(fixed(mean_hold_mm(errors), 3));
    cells.push_back(fixed(mean_rms_mm(errors), 3));
  }
  return cells;
}

std::string PlayReport::text(bool watched) const {
  if (!watched) return std::to_string(sent()) + " frames sent\n";
  TextTable table;
  std::vector<std::string> head = targets_;
  if (!head.empty()) head.insert(head.end(), {"mean", "rms"});
  table.add_row(joined({{"trial", "frames", "answered", "lost", "valid"}, head}));
  const auto counts = [](std::size_t frames, std::size_t answers, std::size_t valid) {
    return std::vector<std::string>{std::to_string(frames), std::to_string(answers), std::to_string(frames - answers),
                                    std::to_string(valid)};
  };
  std::size_t all_valid = 0;
  for (const Row& row : rows_) {
    const auto found = row.validity.find(protocol::to_string(protocol::Validity::valid));
    const std::size_t valid = found == row.validity.end() ? 0 : found->second;
    all_valid += valid;
    table.add_row(joined({{row.trial}, counts(row.sent, row.answered, valid), error_cells(row.errors)}));
  }
  if (rows_.size() > 1) {
    table.add_row(joined({{"all"}, counts(sent(), answered(), all_valid), error_cells(mean_errors())}));
  }
  std::string text = table.text();
  if (!targets_.empty()) {
    text +=
        "\nT..., mean: error in the hold, mm, of mean prediction against mean recorded place; rms: of single frames,\n"
        "noise of the recorded targets included, mean over targets.\n";
  }
  text += '\n' + latency_line("receive to send", receive_to_send_) + latency_line("step", step_) +
          latency_line("there and back", round_trip_);
  if (innovations_ > 0) {
    const double rms = std::sqrt(innovation_square_sum_ / static_cast<double>(innovations_));
    text += pad_to("innovation", 16, false) + "rms " + fixed(rms, 3) + " mm\n";
  }
  return text;
}

nlohmann::json PlayReport::json() const {
  nlohmann::json trials = nlohmann::json::array();
  for (const Row& row : rows_) {
    trials.push_back({{"trial", row.trial},
                      {"frames", row.sent},
                      {"answered", row.answered},
                      {"lost", row.sent - row.answered},
                      {"validity", row.validity},
                      {"targets", errors_json(row.errors)},
                      {"hold_mean_mm", number_or_null(mean_hold_mm(row.errors))},
                      {"rms_mean_mm", number_or_null(mean_rms_mm(row.errors))}});
  }
  const std::vector<TargetError> means = mean_errors();
  return {{"trials", trials},
          {"mean",
           {{"targets", errors_json(means)},
            {"hold_mm", number_or_null(mean_hold_mm(means))},
            {"rms_mm", number_or_null(mean_rms_mm(means))}}},
          {"frames", sent()},
          {"answered", answered()},
          {"lost", sent() - answered()},
          {"latency_ms",
           {{"receive_to_send", latency_json(receive_to_send_)},
            {"step", latency_json(step_)},
            {"there_and_back", latency_json(round_trip_)}}}};
}

}  // namespace tissued::daemon
