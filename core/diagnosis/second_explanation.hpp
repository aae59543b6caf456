// A second explanation beside the first.
#pragma once

#include "core/diagnosis/work.hpp"

namespace tissued::core {

// Pairs of the likeliest explanation and every other one, into the second round. Of one that was looked for before
// nothing is left.
void find_second(Work& work, SearchResult& result);

// Each half of a pair that would be said is to be needed: fitted from where the pair ended, the other one alone may
// explain as much, for which the first one only stood in, or whose own fit had not come as far. The better half leads
// the first round then. Out of time, a pair is not believed of which a half may be as large as nothing. True: the pair
// is not needed, and no pair of what leads now was tried.
bool refit_halves(Work& work, SearchResult& result);

// Elements err differently beside the first explanation than where they were judged: where a second one would be said,
// that must not be what it explains.
void judge_second(const SearchOptions& options, Work& work, SearchResult& result);

}  // namespace tissued::core
