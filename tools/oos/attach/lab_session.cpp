#include "tools/oos/attach/lab_session.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "lab/load_lab.hpp"
#include "tools/oos/attach/lease.hpp"
#include "tools/oos/attach/places.hpp"

namespace oos {
namespace {

constexpr const char* kKeyFiles[] = {"allowed", "oos.key", "visual_node.key", "client.key"};

bool WriteKey(const std::filesystem::path& file, const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
  if (fd < 0) return false;
  const bool is_written = write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  return close(fd) == 0 && is_written;
}

// Keys of earlier runs are removed.
core::Result<std::filesystem::path> KeepKeys(const std::string& run, const Answer& answer) {
  const std::filesystem::path all = SessionFolder() / "lab_keys", folder = all / run;
  std::error_code error;
  if (const auto made = MakeSessionFolder(); !made) return tl::unexpected(made.error());
  std::filesystem::remove_all(all, error);
  if (mkdir(all.c_str(), 0700) != 0 || mkdir(folder.c_str(), 0700) != 0) {
    return core::Fail(core::ErrorCode::kIo, "cannot make " + folder.string() + " for the session's keys");
  }
  for (const char* name : kKeyFiles) {
    const auto lines = answer.values(name);
    if (lines.empty()) {
      return core::Fail(core::ErrorCode::kNotFound, std::string("the registry's host has no ") + name +
                                                        " for us; was the run launched by an older version?");
    }
    if (!WriteKey(folder / name, lines)) {
      return core::Fail(core::ErrorCode::kIo, "cannot write " + (folder / name).string());
    }
  }
  return folder;
}

}  // namespace

core::Result<LabSession> FindLabSession(const std::string& lab_file) {
  const auto lab = lab::LoadLab(lab_file);
  if (!lab) return core::Fail(core::ErrorCode::kInvalidInput, scene::Format(lab.error().front()));
  Remotes remotes(lab->hosts);
  const auto complaints = remotes.Reach();
  if (!complaints) return tl::unexpected(complaints.error());
  const auto states = ReadLeases(&remotes);
  if (!states) return tl::unexpected(states.error());
  const Lease lease = ChooseRun(*states, lab->file.string());
  if (lease.values.empty()) {
    std::string why = "nothing runs in lab " + lab->name;
    for (const std::string& complaint : *complaints) why += "; " + complaint;
    return core::Fail(core::ErrorCode::kNotFound, why);
  }
  for (std::size_t i = 0; i < lab->hosts.size(); ++i) {
    if (lab->hosts[i].name != lab->registry_host || (*states)[i].lease.value("run") != lease.value("run")) continue;
    std::string script = "cd " + (*states)[i].root + "/keys || exit 1\n";
    for (const char* name : kKeyFiles) script += std::string("sed 's/^/") + name + "=/' " + name + " || exit 1\n";
    const auto keys = KeepKeys(lease.value("run"), remotes.Run(i, script));
    if (!keys) return tl::unexpected(keys.error());
    return LabSession{lease.value("registry"), lease.value("session"), lease.value("scenario"), *keys};
  }
  return core::Fail(core::ErrorCode::kNotFound, "host " + lab->registry_host + ", which has the registry of run " +
                                                    lease.value("run") + ", does not describe the run; see " +
                                                    "'oos status --lab " + lab->file.string() + "'");
}

}  // namespace oos
