#pragma once

#include <cstdint>

namespace failures {

// Calls of operator new that this thread has made. A program that links this room counts them all.
std::uint64_t AllocationsOfThread();

}  // namespace failures
