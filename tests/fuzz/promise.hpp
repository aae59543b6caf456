#pragma once

#include <cstdio>
#include <cstdlib>

namespace tissued::fuzz {

// Stops the fuzzer with the input that broke `what`.
inline void promise(bool kept, const char* what) {
  if (kept) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

}  // namespace tissued::fuzz
