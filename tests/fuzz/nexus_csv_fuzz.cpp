// Any bytes as a Nexus export: a sound trial that survives a round trip unchanged, or a TrialError.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "protocol/nexus_csv.hpp"
#include "tests/fuzz/trial_promises.hpp"

using namespace tissued::protocol;
using tissued::fuzz::promise;

namespace {

std::optional<std::string> written(const Trial& trial) {
  try {
    return format_nexus_csv(trial);
  } catch (const std::invalid_argument&) {
    // A carriage return inside a name is read, but not written.
    const auto odd = [](const std::string& name) { return name.find('\r') != std::string::npos; };
    promise(std::any_of(trial.labels.begin(), trial.labels.end(), odd) ||
                std::any_of(trial.subjects.begin(), trial.subjects.end(), odd) ||
                std::any_of(trial.devices.begin(), trial.devices.end(), odd),
            "names that were read can be written");
    return std::nullopt;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  Trial trial;
  try {
    trial = parse_nexus_csv(text, "fuzz.csv");
  } catch (const TrialError& error) {
    promise(error.line() >= 0, "an error has a line or none");
    return 0;
  }
  tissued::fuzz::check_trial(trial);
  // Not caught: what we write must be read.
  if (const auto once = written(trial))
    promise(format_nexus_csv(parse_nexus_csv(*once, "once.csv")) == *once, "round trip");
  return 0;
}
