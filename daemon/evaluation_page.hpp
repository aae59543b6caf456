#pragma once

#include <string>

#include "daemon/evaluation.hpp"

namespace tissued::daemon {

/// The evaluation as one HTML page: style and figures inside, nothing loaded from anywhere, no scripts. `threads`: on
/// how many it ran, for the reader of step times.
std::string evaluation_page(const Evaluation& evaluation, int threads);

}  // namespace tissued::daemon
