// A second explanation beside the first.
#pragma once

#include "core/diagnosis/work.hpp"

namespace tissued::core {

// Looks for a second explanation beside the likeliest of the first round: pairs of it and every other one, into the
// second round. Once more beside the half that was enough, where it was not the one that had led.
void explain_further(const SearchOptions& options, Work& work, SearchResult& result);

// Each half of a pair that would be said is to be needed: fitted from where the pair ended, the other one alone may
// explain as much, for which the first one only stood in, or whose own fit had not come as far. The better half leads
// the first round then. Out of time, a pair is not believed of which a half may be as large as nothing. True: the pair
// is not needed, and no pair of what leads now was tried.
bool refit_halves(Work& work, SearchResult& result);

}  // namespace tissued::core
