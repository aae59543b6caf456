#pragma once

#include <string>
#include <vector>

namespace tissued::daemon {

/// One way of simulating that is compared with others: what it is called, and the keys of the configuration that make
/// it, `simulator.kind=admm` and so on.
struct EvaluatedModel {
  std::string name;
  std::vector<std::string> overrides;
};

/// A model by its name: a simulator (core::simulator_names(), everything else at its default), or
/// `paper`: KF-ADMM as the first paper prints it, `paper-admm`: the paper's open loop. Throws UsageError.
EvaluatedModel named_model(const std::string& name);

/// `NAME:KEY=VALUE,KEY=VALUE,...`; commas inside of [] belong to the value. Or `NAME:FILE.json`: all that a
/// configuration, such as `tissuectl calibrate` writes, says beside its bundle. Throws UsageError, config::ConfigError.
EvaluatedModel parse_variant(const std::string& text);

/// What named_model knows.
std::vector<std::string> model_names();

}  // namespace tissued::daemon
