#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "core/result.hpp"

namespace bus::log {

// The content of a file, with its length when it was opened. A large file is mapped, so that the kernel may reclaim its
// pages: a recording of an hour is larger than the memory. A small one is copied.
//
// If a mapped file is truncated meanwhile, reading the missing pages ends the process (SIGBUS). That is accepted:
// writers of recordings only append.
class MappedFile {
 public:
  static constexpr std::size_t kMaxCopied = std::size_t{1} << 20;  // below, a copy is cheap and immune to truncation

  // Errors: kIo; kResource when it cannot be mapped.
  static core::Result<MappedFile> Open(const std::filesystem::path& path);
  MappedFile(MappedFile&& other) noexcept : copy_(std::move(other.copy_)), mapped_(std::exchange(other.mapped_, {})) {}
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile();

  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return mapped_.empty() ? copy_ : mapped_; }

 private:
  MappedFile() = default;

  std::vector<std::uint8_t> copy_;
  std::span<const std::uint8_t> mapped_;
};

}  // namespace bus::log
