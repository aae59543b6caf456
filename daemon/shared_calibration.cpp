#include "daemon/shared_calibration.hpp"

#include <chrono>
#include <exception>
#include <stdexcept>
#include <thread>

#include "daemon/shared_jobs.hpp"

namespace tissued::daemon {
namespace {

using nlohmann::json;

constexpr std::chrono::milliseconds kBetweenLooks{20};

}  // namespace

SharedCalibration::SharedCalibration(const MpiRanks& ranks, const Calibration& calibration, int workers)
    : ranks_(ranks), calibration_(calibration), workers_(workers) {}

// No points: that was all.
SharedCalibration::~SharedCalibration() {
  if (ranks_.rank() != 0) return;
  for (int rank = 1; rank < ranks_.size(); ++rank) ranks_.send(rank, "[]");
}

// A job is one trial at one point. On rank 0 the parts, trials of a point after each other.
std::vector<double> SharedCalibration::parts_of(const std::vector<SearchPoint>& points) const {
  const std::size_t trials = calibration_.trials();
  const auto play = [&](int job) -> json {
    const auto number = static_cast<std::size_t>(job);
    try {
      return calibration_.part(points[number / trials], number % trials);
    } catch (const std::exception& error) {
      return error.what();
    }
  };
  bool failed = false;
  const auto look = [&failed](int, const json& part) { failed = failed || part.is_string(); };
  const json parts =
      share_jobs(ranks_, static_cast<int>(points.size() * trials), workers_, play, look, [&failed] { return failed; });
  for (const json& part : parts)
    if (part.is_string()) throw std::runtime_error(part.get<std::string>());
  return parts.is_array() ? parts.get<std::vector<double>>() : std::vector<double>();
}

std::vector<double> SharedCalibration::operator()(const std::vector<SearchPoint>& points) const {
  if (points.empty()) return {};
  for (int rank = 1; rank < ranks_.size(); ++rank) ranks_.send(rank, json(points).dump());
  const std::vector<double> parts = parts_of(points);
  const std::size_t trials = calibration_.trials();
  std::vector<double> sums;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double sum = 0.0;
    for (std::size_t trial = 0; trial < trials; ++trial) sum += parts[i * trials + trial];
    sums.push_back(sum < Calibration::kRefused ? sum : Calibration::kRefused);
  }
  return sums;
}

void SharedCalibration::serve() const {
  for (;;) {
    const auto message = ranks_.poll();
    if (!message) {
      std::this_thread::sleep_for(kBetweenLooks);
      continue;
    }
    const auto points = json::parse(message->text).get<std::vector<SearchPoint>>();
    if (points.empty()) return;
    parts_of(points);
  }
}

}  // namespace tissued::daemon
