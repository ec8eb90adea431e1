#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace fuzz {

// A folder in memory for parsers that read files; it is removed when the process ends.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  // Writes or replaces path()/name.
  std::filesystem::path Write(const char* name, std::span<const std::uint8_t> bytes) const;

 private:
  std::filesystem::path path_;
};

}  // namespace fuzz
