#include "tools/oos/attach/lease.hpp"

#include <sys/utsname.h>
#include <unistd.h>

#include <cstdlib>

namespace oos {
namespace {

Lease LeaseOf(const Answer& answer) {
  Lease lease;
  for (const char* key :
       {"run", "who", "pid", "boot", "scenario", "lab", "out", "registry", "session", "since", "stopping"}) {
    if (const std::string value = answer.value(key); !value.empty()) lease.values[key] = value;
  }
  return lease;
}

std::string FolderOf(const std::string& root, const std::string& run) {
  return root + "/runs/" + run;
}

// Finds processes by the run's name, which each of them has in its environment (OOS_RUN).
std::string SearchFor(const std::string& run) {
  return "for e in /proc/[0-9]*/environ; do\n  if tr '\\0' '\\n' <$e 2>/dev/null | grep -qx 'OOS_RUN=" + run +
         "'; then\n    p=${e#/proc/}; p=${p%/environ}\n"
         "    echo \"left=process $p: $(tr '\\0' ' ' </proc/$p/cmdline 2>/dev/null)\"\n  fi\ndone\n";
}

core::Result<void> InUse(const std::string& host, const Lease& lease) {
  return core::Fail(core::ErrorCode::kResource, "host " + host + " is in use: " + lease.Describe() +
                                                    "; wait, or end it with 'oos stop --lab " + lease.value("lab") +
                                                    "'");
}

}  // namespace

std::string Lease::value(const std::string& key) const {
  const auto it = values.find(key);
  return it == values.end() ? "" : it->second;
}

std::string Lease::Describe() const {
  return value("who") + " (process " + value("pid") + ") runs " + value("run") + " of " + value("lab") + " since " +
         value("since");
}

bool IsPlain(const std::string& path) {
  return path.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789/._+@-") ==
         std::string::npos;
}

std::string UserAtHost() {
  utsname name{};
  uname(&name);
  const char* user = std::getenv("USER");
  return std::string(user != nullptr ? user : "uid " + std::to_string(getuid())) + "@" + name.nodename;
}

core::Result<std::vector<HostState>> ReadLeases(Remotes* remotes) {
  std::vector<std::string> scripts;
  for (std::size_t i = 0; i < remotes->hosts().size(); ++i) {
    scripts.push_back(remotes->is_reached(i)
                          ? "cd '" + remotes->hosts()[i].run_folder +
                                "' 2>/dev/null || exit 0\necho root=$(pwd -P)\ncat lease 2>/dev/null\n:\n"
                          : "");
  }
  const std::vector<Answer> answers = remotes->RunAll(scripts);
  std::vector<HostState> states;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (!answers[i].is_good()) {
      return core::Fail(core::ErrorCode::kIo, "host " + remotes->hosts()[i].name + ": " + answers[i].err);
    }
    states.push_back({answers[i].value("root"), LeaseOf(answers[i])});
    if (IsPlain(states.back().root) && IsPlain(states.back().lease.value("run"))) continue;
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "host " + remotes->hosts()[i].name + ": its run folder is " + states.back().root + " with run '" +
                          states.back().lease.value("run") +
                          "', and they become part of commands; give it a run_folder of letters, digits and /._+@-");
  }
  return states;
}

Lease ChooseRun(const std::vector<HostState>& states, const std::string& lab_file) {
  Lease chosen;
  for (const HostState& state : states) {
    if (!state.lease.values.empty() && state.lease.value("lab") == lab_file) return state.lease;
    if (chosen.values.empty()) chosen = state.lease;
  }
  return chosen;
}

core::Result<void> CheckFree(Remotes* remotes) {
  const auto states = ReadLeases(remotes);
  if (!states) return tl::unexpected(states.error());
  for (std::size_t i = 0; i < states->size(); ++i) {
    if (!(*states)[i].lease.values.empty()) return InUse(remotes->hosts()[i].name, (*states)[i].lease);
  }
  return {};
}

core::Result<void> TakeLeases(const Lease& lease, const std::vector<std::string>& roots, Remotes* remotes) {
  std::string text;
  for (const auto& [key, value] : lease.values) text += key + "=" + value + "\n";
  for (std::size_t i = 0; i < roots.size(); ++i) {
    // `set -C` makes the redirection fail when the file exists: of several launchers exactly one wins.
    const Answer answer = remotes->Run(i, "cd " + roots[i] + "\nset -C\nif cat 2>/dev/null >lease <<'END_OF_LEASE'\n" +
                                              text + "END_OF_LEASE\nthen echo taken=1; else cat lease; fi\n");
    if (answer.value("taken") == "1") continue;
    const std::vector<std::string> taken(roots.begin(), roots.begin() + static_cast<std::ptrdiff_t>(i));
    ReleaseLeases(lease.value("run"), taken, remotes);
    return InUse(remotes->hosts()[i].name, LeaseOf(answer));
  }
  return {};
}

void MarkStopping(const std::string& run, const std::string& who, const std::vector<std::string>& roots,
                  Remotes* remotes) {
  std::vector<std::string> scripts;
  for (const std::string& root : roots) {
    scripts.push_back(root.empty()
                          ? ""
                          : "cd " + root + " && grep -qx 'run=" + run +
                                "' lease && cat >>lease <<'END_OF_LEASE'\nstopping=" + who + "\nEND_OF_LEASE\n");
  }
  remotes->RunAll(scripts, 10.0);
}

void ReleaseLeases(const std::string& run, const std::vector<std::string>& roots, Remotes* remotes) {
  std::vector<std::string> scripts(remotes->hosts().size());
  for (std::size_t i = 0; i < roots.size(); ++i) {
    if (roots[i].empty()) continue;
    scripts[i] = "cd " + roots[i] + " && grep -qx 'run=" + run + "' lease && rm -rf keys && rm -f lease\n";
  }
  remotes->RunAll(scripts, 10.0);
}

std::vector<std::string> StopRun(const std::string& run, const std::vector<std::string>& roots, Remotes* remotes) {
  std::vector<std::string> stops, searches;
  for (const std::string& root : roots) {
    const std::string script = FolderOf(root, run) + "/stop.sh";
    stops.push_back(root.empty() ? "" : "[ ! -e " + script + " ] || sh " + script + " >&2\n");
    searches.push_back(root.empty() ? "" : SearchFor(run));
  }
  remotes->RunAll(stops, 40.0);
  const std::vector<Answer> answers = remotes->RunAll(searches, 20.0);
  std::vector<std::string> left;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const std::string& name = remotes->hosts()[i].name;
    if (!answers[i].is_good()) left.push_back("host " + name + " did not report what is left: " + answers[i].err);
    for (const std::string& process : answers[i].values("left")) left.push_back("host " + name + ": " + process);
  }
  return left;
}

core::Result<void> Collect(const std::string& run, const std::vector<std::string>& roots,
                           const std::filesystem::path& out, Remotes* remotes) {
  std::error_code error;
  std::filesystem::create_directories(out, error);
  std::string failures;
  for (std::size_t i = 0; i < roots.size(); ++i) {
    if (roots[i].empty()) continue;
    const std::string folder = FolderOf(roots[i], run);
    if (!remotes->Run(i, "[ -d " + folder + " ]\n").is_good()) continue;
    auto words = remotes->Rsync(i);
    words.insert(words.end(), {"--exclude=*.sh", "--exclude=supervisord.conf", "--exclude=*.service",
                               remotes->Target(i, folder + "/"), out.string() + "/"});
    const auto fetched = RunHere(words, "", 600.0);
    if (fetched && fetched->is_good()) {
      remotes->Run(i, "rm -rf " + folder + "\n");
    } else {
      failures += "host " + remotes->hosts()[i].name + ": " + (fetched ? fetched->err : fetched.error().detail) +
                  " (what the run left stays in " + folder + ")\n";
    }
  }
  if (!failures.empty()) return core::Fail(core::ErrorCode::kIo, failures);
  return {};
}

}  // namespace oos
