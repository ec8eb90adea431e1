#include "replay/platform.hpp"

#include <gnu/libc-version.h>

#include <fstream>
#include <string>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace replay {
namespace {

constexpr unsigned kFlushes = 0x8000U | 0x0040U;  // flush to zero, denormals are zero

std::string CpuName() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    if (line.starts_with("model name")) return line.substr(std::min(line.find(": ") + 2, line.size()));
  }
  return "unknown";
}

}  // namespace

bus::log::TextMap DescribePlatform() {
  bus::log::TextMap platform;
  platform["simd"] = "portable";
  platform["denormals"] = "kept";
  std::string fma = "without FMA";
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) platform["simd"] = "AVX2";
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) platform["simd"] = "AVX-512";
  if (__builtin_cpu_supports("fma") && __builtin_cpu_supports("avx2")) fma = "with FMA";
  if ((_mm_getcsr() & kFlushes) == kFlushes) platform["denormals"] = "flushed";
#endif
  platform["libm"] = std::string("glibc ") + gnu_get_libc_version() + " " + fma;
  platform["cpu"] = CpuName();
  platform["compiler"] = "GCC " __VERSION__;
  return platform;
}

bool GivesSameBits(const bus::log::TextMap& recorded, const bus::log::TextMap& here) {
  for (const char* key : {"libm", "compiler"}) {
    const auto found = recorded.find(key);
    if (found == recorded.end() || found->second != here.at(key)) return false;
  }
  return true;
}

void SetDenormals(const std::string& how) {
#if defined(__SSE2__)
  _mm_setcsr(how == "flushed" ? _mm_getcsr() | kFlushes : _mm_getcsr() & ~kFlushes);
#else
  (void)how;
#endif
}

}  // namespace replay
