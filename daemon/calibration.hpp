#pragma once

#include <string>
#include <vector>

#include "config/bundle.hpp"
#include "config/json_reader.hpp"
#include "daemon/parameter_search.hpp"
#include "daemon/recording.hpp"

namespace tissued::daemon {

/// Where a dotted key is in a configuration.
config::JsonPointer pointer_to(const std::string& key);

struct CalibrationRequest {
  std::string bundle;  ///< folder
  std::string model;   ///< simulator.kind
  std::vector<VariedKey> keys;
  std::vector<std::string> targets;    ///< empty: all
  std::vector<std::string> trials;     ///< empty: all that are not held out
  std::vector<std::string> overrides;  ///< of the configuration
};

/// How far a model's answers are from recordings: equation (6) of Tagliabue et al. 2019, the sum over trials and
/// targets of the distance, mm, between the target where it is predicted and where it was recorded, each over the hold
/// as `evaluate` has it. Every trial is played from rest.
class Calibration {
 public:
  /// Reads everything and tries every bound, so that what is wrong comes out before anything runs. Throws UsageError,
  /// config::ConfigError (a key or bound that the configuration refuses) and what reading a bundle throws.
  explicit Calibration(const CalibrationRequest& request);
  Calibration(const Calibration&) = delete;  // recordings refer to the bundle
  Calibration& operator=(const Calibration&) = delete;

  /// How many trials are played.
  std::size_t trials() const { return recordings_.size(); }

  /// What a trial adds to the sum at `point`; kRefused where the configuration refuses the point, such as a
  /// cluster_radius below half of its cluster_spacing. On one thread; may be called beside itself. Throws
  /// core::ModelError where a model cannot be built.
  double part(const SearchPoint& point, std::size_t trial) const;

  /// How many distances are summed up.
  std::size_t distances() const { return distances_; }

  /// What tissued is started with to run the model at `point`.
  config::Json config_at(const SearchPoint& point) const;

  static constexpr double kRefused = 1e9;  ///< mm

 private:
  std::vector<std::string> overrides_at(const SearchPoint& point) const;
  void try_bounds() const;
  bool is_wanted(std::size_t target) const;

  CalibrationRequest request_;
  config::Bundle bundle_;
  std::vector<Recording> recordings_;
  std::size_t distances_ = 0;
};

}  // namespace tissued::daemon
