#include "bus/log/mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "core/read_file.hpp"

namespace bus::log {

core::Result<MappedFile> MappedFile::Open(const std::filesystem::path& path) {
  MappedFile file;
  struct stat status {};
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool is_large = fd >= 0 && fstat(fd, &status) == 0 && S_ISREG(status.st_mode) &&
                        static_cast<std::size_t>(status.st_size) > kMaxCopied;
  if (!is_large) {
    if (fd >= 0) close(fd);
    auto bytes = core::ReadFile(path);
    if (!bytes) return core::Fail(core::ErrorCode::kIo, path.string() + ": " + bytes.error().detail);
    file.copy_ = std::move(*bytes);
    return file;
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  void* begin = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
  const int error = errno;
  close(fd);
  if (begin == MAP_FAILED) {
    return core::Fail(core::ErrorCode::kResource, path.string() + ": its " + std::to_string(size >> 20) +
                                                      " MiB cannot be mapped: " + std::strerror(error) +
                                                      "; is there a limit on address space (ulimit -v)?");
  }
  madvise(begin, size, MADV_SEQUENTIAL);
  file.mapped_ = {static_cast<const std::uint8_t*>(begin), size};
  return file;
}

MappedFile::~MappedFile() {
  if (!mapped_.empty()) munmap(const_cast<std::uint8_t*>(mapped_.data()), mapped_.size());
}

}  // namespace bus::log
