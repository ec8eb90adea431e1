#include "tools/oos/attach/places.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

namespace oos {
namespace {

std::string Reason() {
  return std::error_code(errno, std::generic_category()).message();
}

// Whether it is a directory (no link) of this user in which others have none of these permissions.
bool IsOurs(const std::string& folder, mode_t others) {
  struct stat info {};
  return lstat(folder.c_str(), &info) == 0 && S_ISDIR(info.st_mode) && info.st_uid == geteuid() &&
         (info.st_mode & others) == 0;
}

// Checks the folder: in /tmp another user may have made it first.
core::Result<void> CheckSessionFolder() {
  const std::string folder = SessionFolder().string();
  if (IsOurs(folder, 077)) return {};
  if (access(folder.c_str(), F_OK) != 0) {
    return core::Fail(core::ErrorCode::kNotFound,
                      "no session runs here (" + folder + ": " + Reason() + "); start one with 'oos run SCENARIO'");
  }
  return core::Fail(core::ErrorCode::kInvalidInput,
                    folder +
                        " is not a directory (no link) of this user alone, as 'oos run' makes it; a session noted "
                        "there may be a trap: remove it, or set XDG_RUNTIME_DIR to a folder of your own");
}

}  // namespace

std::filesystem::path SessionFolder() {
  if (const char* runtime = std::getenv("XDG_RUNTIME_DIR"); runtime != nullptr && *runtime != '\0') {
    return std::filesystem::path(runtime) / "vr_oos";
  }
  return "/tmp/vr_oos-" + std::to_string(geteuid());
}

std::filesystem::path SessionFile() {
  return SessionFolder() / "session.json";
}

core::Result<void> MakeSessionFolder() {
  std::error_code error;
  std::filesystem::create_directories(SessionFolder().parent_path(), error);
  if (mkdir(SessionFolder().c_str(), 0700) != 0 && errno != EEXIST) {
    return core::Fail(core::ErrorCode::kIo, "cannot make " + SessionFolder().string() +
                                                ", where the session is noted: " + Reason() +
                                                "; set XDG_RUNTIME_DIR to a folder of your own");
  }
  if (IsOurs(SessionFolder().string(), 022))
    chmod(SessionFolder().c_str(), 0700);  // earlier versions let others read it
  return CheckSessionFolder();
}

core::Result<void> WriteSessionNote(const std::string& json) {
  if (auto made = MakeSessionFolder(); !made) return made;
  const std::string file = SessionFile().string();
  const std::string fresh = file + "." + std::to_string(getpid());
  unlink(fresh.c_str());  // of a process that died while it wrote
  const int fd = open(fresh.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
  const bool is_written = fd >= 0 && write(fd, json.data(), json.size()) == static_cast<ssize_t>(json.size());
  if (fd >= 0) close(fd);
  if (is_written && rename(fresh.c_str(), file.c_str()) == 0) return {};
  return core::Fail(core::ErrorCode::kIo, "cannot write " + file + ": " + Reason() + "; is there room?");
}

core::Result<std::string> ReadSessionNote() {
  if (auto is_ours = CheckSessionFolder(); !is_ours) return tl::unexpected(is_ours.error());
  std::ifstream file(SessionFile());
  return std::string(std::istreambuf_iterator<char>(file), {});
}

std::filesystem::path ProgramFolder() {
  if (const char* folder = std::getenv("VR_OOS_BIN_DIR"); folder != nullptr && *folder != '\0') return folder;
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
}

}  // namespace oos
