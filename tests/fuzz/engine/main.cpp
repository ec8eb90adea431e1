#include "tests/fuzz/targets.hpp"

// libFuzzer's entry. Built once for each target; FUZZ_TARGET names its function.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::FUZZ_TARGET({data, size});
  return 0;
}
