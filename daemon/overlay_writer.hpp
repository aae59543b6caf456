#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/prediction_client.hpp"

namespace tissued::daemon {

struct OverlayRequest {
  std::vector<std::filesystem::path> images;  ///< PNG, as large as the probe's calibration says
  std::filesystem::path folder;               ///< where a file of the same name is written for each
  std::string probe;                          ///< empty: the scene's first
};

/// Draws targets on one image after the other, each with the next frame that the daemon answers, and says on stdout
/// what it wrote. Throws NoAnswer where no view comes for two seconds, std::runtime_error where there is no such probe,
/// it has no calibrated image, or a file cannot be read or written.
void write_overlays(PredictionClient& client, const OverlayRequest& request);

}  // namespace tissued::daemon
