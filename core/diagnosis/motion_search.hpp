// The search for what is wrong where inertia matters: bodies that swing after they were let go, or that are shaken.
#pragma once

#include "core/diagnosis/search.hpp"

namespace tissued::core {

// Candidates are compared by the first swings and by where the body comes to rest; what is chosen is then fitted to all
// that was seen. As search.
SearchResult search_motion(const RecordedSession& session, const SearchOptions& options);

}  // namespace tissued::core
