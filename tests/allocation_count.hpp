#pragma once

#include <cstddef>

// How often all threads of this program have asked the heap for memory so far, by `new`.
std::size_t allocation_count();
