#include "core/read_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace core {
namespace {

tl::unexpected<Error> ReadError() {
  return Fail(errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo,
              std::string("cannot be read: ") + std::strerror(errno));
}

// Reads to the end, whatever size fstat reports: a file may grow meanwhile, and files in /proc report 0.
bool ReadAll(int fd, std::vector<std::uint8_t>* bytes) {
  struct stat status {};
  if (fstat(fd, &status) != 0) return false;
  std::size_t used = 0;
  bytes->resize(static_cast<std::size_t>(status.st_size) + 1);
  for (;;) {
    const ssize_t got = read(fd, bytes->data() + used, bytes->size() - used);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    used += static_cast<std::size_t>(got);
    if (got == 0) break;
    if (used == bytes->size()) bytes->resize(2 * used);
  }
  bytes->resize(used);
  return true;
}

}  // namespace

Result<std::vector<std::uint8_t>> ReadFile(const std::filesystem::path& file) {
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return ReadError();
  std::vector<std::uint8_t> bytes;
  const bool is_read = ReadAll(fd, &bytes);
  const int error = errno;
  close(fd);
  errno = error;
  if (!is_read) return ReadError();
  return bytes;
}

}  // namespace core
