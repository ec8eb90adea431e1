#pragma once

#include <filesystem>
#include <string>
#include <utility>

namespace oos {

// Follows a log file that another process writes.
class LogTail {
 public:
  explicit LogTail(std::filesystem::path file) : file_(std::move(file)) {}

  // The last whole line written since the last call; empty if there is none.
  std::string NewestLine();

 private:
  std::filesystem::path file_;
  std::streamoff read_bytes_ = 0;
};

}  // namespace oos
