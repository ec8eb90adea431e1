#include "tests/fuzz/scratch_folder.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "tests/fuzz/claim.hpp"

namespace fuzz {

ScratchFolder::ScratchFolder() {
  std::error_code error;
  const bool has_memory = std::filesystem::is_directory("/dev/shm", error);
  const std::filesystem::path parent = has_memory ? "/dev/shm" : std::filesystem::temp_directory_path();
  std::string name = (parent / "fuzz-XXXXXX").string();
  Claim(mkdtemp(name.data()) != nullptr, "a folder can be made");
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code error;
  std::filesystem::remove_all(path_, error);
}

std::filesystem::path ScratchFolder::Write(const char* name, std::span<const std::uint8_t> bytes) const {
  const std::filesystem::path file = path_ / name;
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  Claim(fd >= 0, "the file can be written");
  Claim(write(fd, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()), "the file takes its bytes");
  close(fd);
  return file;
}

}  // namespace fuzz
