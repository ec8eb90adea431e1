#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz/targets.hpp"

// Runs the stored inputs of every fuzzer in an ordinary build: unchanged, cut short and with single bits flipped. A
// target aborts when a claim does not hold.

namespace fuzz {
namespace {

std::vector<std::uint8_t> ReadAll(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::vector<std::filesystem::path> InputsOf(const std::string& target) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(VR_OOS_SOURCE_DIR "/tests/fuzz/corpus/" + target)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

class FuzzCorpus : public testing::TestWithParam<NamedTarget> {};

TEST_P(FuzzCorpus, IsTakenWhole) {
  const auto files = InputsOf(GetParam().name);
  ASSERT_FALSE(files.empty());
  for (const auto& file : files) {
    SCOPED_TRACE(file);
    GetParam().run(ReadAll(file));
  }
}

// The damaged places are spread over the input; their number does not grow with its size.
TEST_P(FuzzCorpus, IsTakenDamaged) {
  constexpr std::size_t kNumDamages = 16;
  for (const auto& file : InputsOf(GetParam().name)) {
    SCOPED_TRACE(file);
    const std::vector<std::uint8_t> whole = ReadAll(file);
    for (std::size_t i = 0; i < kNumDamages; ++i) {
      const std::size_t at = whole.size() * i / kNumDamages;
      GetParam().run(Input(whole).first(at));
      if (at >= whole.size()) continue;
      std::vector<std::uint8_t> flipped = whole;
      flipped[at] ^= static_cast<std::uint8_t>(1u << i % 8);
      GetParam().run(flipped);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzCorpus, testing::ValuesIn(kTargets),
                         [](const testing::TestParamInfo<NamedTarget>& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace fuzz
