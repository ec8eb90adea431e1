#include "core/testing/allocations.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::uint64_t> of_all{0};
thread_local std::uint64_t of_thread = 0;

}  // namespace

// Not inlined, else GCC sees free() on memory from new and warns.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  of_all.fetch_add(1, std::memory_order_relaxed);
  ++of_thread;
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
  return of_all.load(std::memory_order_relaxed);
}
std::uint64_t NumAllocationsOfThread() {
  return of_thread;
}

}  // namespace core::test
