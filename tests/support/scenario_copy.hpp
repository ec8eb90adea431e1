#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "collision/resolution/choose_resolutions.hpp"
#include "scene/scenario.hpp"

namespace system_tests {

// A copy of one of the project's scenarios in a temporary folder, to change its files before it is loaded. An error in
// here fails the test that uses it.
class ScenarioCopy {
 public:
  // `variant`: unique among the tests, it names the folder.
  ScenarioCopy(const std::string& scenario, const std::string& variant);

  // Removes the copy, unless the test has failed: then it stays for inspection.
  ~ScenarioCopy();
  ScenarioCopy(const ScenarioCopy&) = delete;
  ScenarioCopy& operator=(const ScenarioCopy&) = delete;

  // Replaces `from`, which must occur in the file exactly once.
  ScenarioCopy& Replace(const std::string& file, const std::string& from, const std::string& to);
  // Replaces the whole file.
  ScenarioCopy& Write(const std::string& file, const std::string& text);
  ScenarioCopy& Remove(const std::string& file);

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  [[nodiscard]] std::string Read(const std::string& file) const;
  // Line of the first occurrence of `text`, from 1; 0: it does not occur.
  [[nodiscard]] int LineOf(const std::string& file, const std::string& text) const;
  [[nodiscard]] scene::Scenario Load() const;

 private:
  std::filesystem::path folder_;
};

inline ScenarioCopy::ScenarioCopy(const std::string& scenario, const std::string& variant)
    : folder_(std::filesystem::path(::testing::TempDir()) / ("vr_oos_" + std::to_string(getpid()) + "_" + variant) /
              scenario) {
  std::filesystem::remove_all(folder_);
  std::filesystem::create_directories(folder_.parent_path());
  std::filesystem::copy(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / scenario, folder_,
                        std::filesystem::copy_options::recursive);
}

inline ScenarioCopy::~ScenarioCopy() {
  std::error_code ignored;
  if (!::testing::Test::HasFailure()) std::filesystem::remove_all(folder_.parent_path(), ignored);
}

inline std::string ScenarioCopy::Read(const std::string& file) const {
  std::ifstream in(folder_ / file, std::ios::binary);
  EXPECT_TRUE(in) << "cannot read " << folder_ / file;
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline ScenarioCopy& ScenarioCopy::Write(const std::string& file, const std::string& text) {
  std::ofstream out(folder_ / file, std::ios::binary | std::ios::trunc);
  out << text;
  EXPECT_TRUE(out.flush()) << "cannot write " << folder_ / file;
  return *this;
}

inline ScenarioCopy& ScenarioCopy::Replace(const std::string& file, const std::string& from, const std::string& to) {
  std::string text = Read(file);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "'" << from << "' is not in " << file << " any more";
  if (at == std::string::npos) return *this;
  EXPECT_EQ(text.find(from, at + 1), std::string::npos) << "'" << from << "' is in " << file << " more than once";
  return Write(file, text.replace(at, from.size(), to));
}

inline ScenarioCopy& ScenarioCopy::Remove(const std::string& file) {
  EXPECT_TRUE(std::filesystem::remove(folder_ / file)) << file << " is not there any more";
  return *this;
}

inline int ScenarioCopy::LineOf(const std::string& file, const std::string& text) const {
  const std::string content = Read(file);
  const std::size_t at = content.find(text);
  if (at == std::string::npos) return 0;
  return 1 + static_cast<int>(std::count(content.begin(), content.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

inline scene::Scenario ScenarioCopy::Load() const {
  const auto scenario = collision::LoadResolvedScenario(folder_);
  if (!scenario) {
    ADD_FAILURE() << scene::Format(scenario.error().front());
    return {};
  }
  return *scenario;
}

}  // namespace system_tests
