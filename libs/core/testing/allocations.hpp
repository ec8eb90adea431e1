#pragma once

#include <cstdint>

namespace core::test {

// Calls of operator new so far: of all threads, and of this one. A program that links this file counts them all.
std::uint64_t NumAllocations();
std::uint64_t NumAllocationsOfThread();

}  // namespace core::test
