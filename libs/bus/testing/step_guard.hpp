#pragma once

// For tests only; include it in exactly one source file of an executable or of a library to preload. It interposes the
// C library's allocator, blocking calls and output streams, and counts the calling thread's calls while it is armed. It
// does not allocate or lock by itself.

#include <dlfcn.h>
#include <execinfo.h>
#include <linux/futex.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>

namespace bus::step_guard {

struct Counts {
  std::uint64_t allocations = 0;  // and releases
  std::uint64_t locks = 0;        // mutex, read-write lock, semaphore, condition, futex wait
  std::uint64_t logs = 0;         // writes to a C stream, which printf and std::cout are too

  [[nodiscard]] std::uint64_t sum() const { return allocations + locks + logs; }
};

constexpr int kMaxFrames = 24;
struct Thread {
  bool is_armed = false;
  bool is_inside = false;  // the guard's own work
  Counts counts;
  std::array<void*, kMaxFrames> first{};  // where the first of them was
  int num_frames = 0;
};

inline thread_local Thread thread_state [[gnu::tls_model("initial-exec")]];

inline void Note(std::uint64_t Counts::*what) noexcept {
  Thread& thread = thread_state;
  if (!thread.is_armed || thread.is_inside) return;
  ++(thread.counts.*what);
  if (thread.num_frames != 0) return;
  thread.is_inside = true;
  thread.num_frames = backtrace(thread.first.data(), kMaxFrames);
  thread.is_inside = false;
}

inline void Arm() {
  thread_state.is_armed = false;
  static thread_local bool is_warm = false;
  if (!is_warm) {
    std::array<void*, 2> frames;
    backtrace(frames.data(), 2);  // loads what it needs
    is_warm = true;
  }
  thread_state.counts = {};
  thread_state.num_frames = 0;
  thread_state.is_armed = true;
}

inline Counts Disarm() {
  thread_state.is_armed = false;
  return thread_state.counts;
}

inline void PrintFirst(int fd) {
  if (thread_state.num_frames != 0) backtrace_symbols_fd(thread_state.first.data(), thread_state.num_frames, fd);
}

template <class F>
F Next(F, const char* name) noexcept {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

}  // namespace bus::step_guard

extern "C" {

void* __libc_malloc(std::size_t size);                           // NOLINT: glibc's names
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT
void* __libc_realloc(void* memory, std::size_t size);            // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT
void __libc_free(void* memory);                                  // NOLINT

void* malloc(std::size_t size) noexcept {
  bus::step_guard::Note(&bus::step_guard::Counts::allocations);
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  bus::step_guard::Note(&bus::step_guard::Counts::allocations);
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) noexcept {
  bus::step_guard::Note(&bus::step_guard::Counts::allocations);
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  bus::step_guard::Note(&bus::step_guard::Counts::allocations);
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  bus::step_guard::Note(&bus::step_guard::Counts::allocations);
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
void free(void* memory) noexcept {
  if (memory != nullptr) bus::step_guard::Note(&bus::step_guard::Counts::allocations);
  __libc_free(memory);
}

// One line for each call that may block: count it, then let the C library do it.
#define VR_OOS_GUARDED(name, parameters, arguments) \
  VR_OOS_COUNTED(&bus::step_guard::Counts::locks, int, name, parameters, arguments)
#define VR_OOS_COUNTED(what, type, name, parameters, arguments)   \
  type name parameters {                                          \
    bus::step_guard::Note(what);                                  \
    static const auto next = bus::step_guard::Next(&name, #name); \
    return next arguments;                                        \
  }
VR_OOS_GUARDED(pthread_mutex_lock, (pthread_mutex_t * mutex) noexcept, (mutex))
VR_OOS_GUARDED(pthread_mutex_timedlock, (pthread_mutex_t * mutex, const timespec* until) noexcept, (mutex, until))
VR_OOS_GUARDED(pthread_rwlock_rdlock, (pthread_rwlock_t * lock) noexcept, (lock))
VR_OOS_GUARDED(pthread_rwlock_wrlock, (pthread_rwlock_t * lock) noexcept, (lock))
VR_OOS_GUARDED(pthread_spin_lock, (pthread_spinlock_t * lock) noexcept, (lock))
VR_OOS_GUARDED(pthread_cond_wait, (pthread_cond_t * condition, pthread_mutex_t* mutex), (condition, mutex))
VR_OOS_GUARDED(pthread_cond_timedwait, (pthread_cond_t * condition, pthread_mutex_t* mutex, const timespec* until),
               (condition, mutex, until))
VR_OOS_GUARDED(pthread_cond_clockwait,
               (pthread_cond_t * condition, pthread_mutex_t* mutex, clockid_t clock, const timespec* until),
               (condition, mutex, clock, until))
VR_OOS_GUARDED(sem_wait, (sem_t * semaphore), (semaphore))
VR_OOS_GUARDED(sem_timedwait, (sem_t * semaphore, const timespec* until), (semaphore, until))
#undef VR_OOS_GUARDED

VR_OOS_COUNTED(&bus::step_guard::Counts::logs, int, puts, (const char* text), (text))
VR_OOS_COUNTED(&bus::step_guard::Counts::logs, int, fputs, (const char* text, FILE* file), (text, file))
VR_OOS_COUNTED(&bus::step_guard::Counts::logs, std::size_t, fwrite,
               (const void* data, std::size_t size, std::size_t count, FILE* file), (data, size, count, file))
#undef VR_OOS_COUNTED

int printf(const char* format, ...) {
  bus::step_guard::Note(&bus::step_guard::Counts::logs);
  std::va_list list;
  va_start(list, format);
  const int written = vprintf(format, list);
  va_end(list);
  return written;
}
int fprintf(FILE* file, const char* format, ...) {
  bus::step_guard::Note(&bus::step_guard::Counts::logs);
  std::va_list list;
  va_start(list, format);
  const int written = vfprintf(file, format, list);
  va_end(list);
  return written;
}

// std::atomic::wait and the like.
long syscall(long number, ...) noexcept {
  std::va_list list;
  va_start(list, number);
  std::array<long, 6> a;
  for (long& argument : a) argument = va_arg(list, long);
  va_end(list);
  if (number == SYS_futex) {
    const long operation = a[1] & FUTEX_CMD_MASK;
    if (operation == FUTEX_WAIT || operation == FUTEX_WAIT_BITSET) {
      bus::step_guard::Note(&bus::step_guard::Counts::locks);
    }
  }
  static const auto next = bus::step_guard::Next(&syscall, "syscall");
  return next(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}

}  // extern "C"
