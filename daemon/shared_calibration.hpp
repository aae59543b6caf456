#pragma once

#include <vector>

#include "daemon/calibration.hpp"
#include "daemon/mpi_ranks.hpp"

namespace tissued::daemon {

/// A calibration's objective, its trials shared out over the threads of every process that mpirun started. All of them
/// make one; rank 0 asks, the others serve until rank 0's is gone.
class SharedCalibration {
 public:
  /// ranks, calibration: outlive it. workers: threads of this rank.
  SharedCalibration(const MpiRanks& ranks, const Calibration& calibration, int workers);
  ~SharedCalibration();
  SharedCalibration(const SharedCalibration&) = delete;
  SharedCalibration& operator=(const SharedCalibration&) = delete;

  /// On rank 0. The sum at every point, Calibration::kRefused where one is refused. Does not depend on how many share.
  /// Throws std::runtime_error with the words of what failed, wherever it did.
  std::vector<double> operator()(const std::vector<SearchPoint>& points) const;

  /// On the others.
  void serve() const;

 private:
  std::vector<double> parts_of(const std::vector<SearchPoint>& points) const;

  const MpiRanks& ranks_;
  const Calibration& calibration_;
  int workers_;
};

}  // namespace tissued::daemon
