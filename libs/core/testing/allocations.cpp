#include "core/testing/allocations.hpp"

#include <array>
#include <atomic>
#include <cstdlib>
#include <new>

namespace {

// Each thread counts in one of these, in a cache line of its own: with one counter for all, threads that allocate much
// would wait for each other, and benchmarks with it.
struct alignas(64) Counter {
  std::atomic<std::uint64_t> count{0};
};
std::array<Counter, 64> counters;
std::atomic<std::size_t> num_threads{0};
thread_local Counter* own = nullptr;
thread_local std::uint64_t of_thread = 0;

void Count() {
  if (own == nullptr) own = &counters[num_threads.fetch_add(1, std::memory_order_relaxed) % counters.size()];
  own->count.fetch_add(1, std::memory_order_relaxed);
  ++of_thread;
}

}  // namespace

// Not inlined, else GCC sees free() on memory from new and warns.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  Count();
  return std::malloc(size);
}
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (void* memory = operator new(size, std::nothrow)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace core::test {

std::uint64_t NumAllocations() {
  std::uint64_t sum = 0;
  for (const Counter& each : counters) sum += each.count.load(std::memory_order_relaxed);
  return sum;
}
std::uint64_t NumAllocationsOfThread() {
  return of_thread;
}

}  // namespace core::test
