#pragma once

#include <string>
#include <vector>

#include "daemon/calibration.hpp"

namespace tissued::daemon {

/// One HTML file that needs nothing else: what a search found, the error and every number by evaluation.
/// evaluated: in order, not empty; best: of them; start: empty where the search was global.
std::string calibration_page(const CalibrationRequest& request, const std::vector<VariedKey>& bounds,
                             const SearchPoint& start, const std::vector<SearchResult>& evaluated,
                             const SearchResult& best, std::size_t distances);

}  // namespace tissued::daemon
