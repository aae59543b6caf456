#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "config/daemon_config.hpp"
#include "core/diagnosis/diagnosis.hpp"

namespace tissued::daemon {

/// A model that a diagnosis arrived at, and how far markers sit from where the bundle has them.
struct ExplainedModel {
  core::Candidate candidate;
  Eigen::VectorXd offset;                  ///< (channels of the scene) mm
  std::map<std::string, double> released;  ///< s, by trial that was fitted: later than its recording says
  /// Of the load: what the model leaves at the markers beyond noise, RMS, where it predicts if that was recorded. None:
  /// as much as is supposed of a body that nobody diagnosed.
  std::optional<double> left;
};

/// Writes model.json ("tissued-model/1"): the numbers of the material, effects by kind with all their numbers, faults
/// of the measurement, and the markers' offsets. Throws std::runtime_error where the file cannot be written.
void write_model(const core::Diagnosis& diagnosis, const core::Scene& scene, const std::filesystem::path& path);

/// Reads what write_model writes, for a scene of the same markers. Throws config::ConfigError, which names file, key
/// and limit.
ExplainedModel read_model(const std::filesystem::path& path, const core::Scene& scene);

/// Makes a configuration that names a model simulate it: material, effects, and the faults of the measurement to undo;
/// the filter supposes as much less model error as the model has shown to leave less.
/// Nothing where it names none. Throws as read_model.
void apply_model(config::DaemonConfig& config);

}  // namespace tissued::daemon
