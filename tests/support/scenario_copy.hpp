#pragma once

#include <filesystem>
#include <string>

#include "scene/scenario.hpp"

namespace system_tests {

// A copy of one of the project's scenarios in a temporary folder, to change its files before it is loaded. Whatever
// goes wrong in here is a failure of the test that asked for it.
class ScenarioCopy {
 public:
  // `variant`: unique among the tests, it names the folder.
  ScenarioCopy(const std::string& scenario, const std::string& variant);

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

}  // namespace system_tests
