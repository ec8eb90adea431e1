#include "tools/oos/attach/remote.hpp"

#include <unistd.h>

#include "core/clock.hpp"

namespace oos {
namespace {

constexpr double kConnectPatience_s = 15.0;

std::int64_t In_ns(double seconds) {
  return core::MonotonicNow_ns() + static_cast<std::int64_t>(seconds * 1e9);
}

std::string LastLine(const std::string& text) {
  const std::size_t end = text.find_last_not_of("\r\n ");
  if (end == std::string::npos) return {};
  const std::size_t begin = text.find_last_of("\r\n", end);
  return text.substr(begin + 1, end - begin);
}

}  // namespace

Remotes::~Remotes() {
  masters_.clear();
  std::error_code error;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, error);
}

std::filesystem::path Remotes::Socket(std::size_t host) const {
  return folder_ / std::to_string(host);
}

core::Result<std::unique_ptr<PipedChild>> Remotes::StartMaster(std::size_t i) const {
  const lab::Host& host = hosts_[i];
  std::vector<std::string> words = {"ssh", "-N", "-T"};
  if (!host.ssh_config.empty()) words.insert(words.end(), {"-F", host.ssh_config.string()});
  if (!host.identity.empty()) {
    words.insert(words.end(), {"-i", host.identity.string(), "-o", "IdentitiesOnly=yes"});
  }
  if (host.ssh_port != 0) words.insert(words.end(), {"-p", std::to_string(host.ssh_port)});
  if (!host.user.empty()) words.insert(words.end(), {"-l", host.user});
  for (const char* option :
       {"BatchMode=yes", "ConnectTimeout=8", "ServerAliveInterval=2", "ServerAliveCountMax=5", "ControlMaster=yes"}) {
    words.insert(words.end(), {"-o", option});
  }
  words.insert(words.end(), {"-S", Socket(i).string(), "--", host.address});
  return PipedChild::Start(words);
}

bool Remotes::Reconnect(std::size_t host) {
  std::unique_ptr<PipedChild>& master = masters_[host];
  master->Poll();
  std::error_code error;
  if (!master->has_ended()) return std::filesystem::exists(Socket(host), error);
  std::filesystem::remove(Socket(host), error);
  if (auto again = StartMaster(host)) master = std::move(*again);
  return false;
}

core::Result<void> Remotes::Connect() {
  const auto complaints = Reach();
  if (!complaints) return tl::unexpected(complaints.error());
  std::string text;
  for (const std::string& complaint : *complaints) text += (text.empty() ? "" : "\n") + complaint;
  if (!text.empty()) return core::Fail(core::ErrorCode::kIo, text);
  return {};
}

core::Result<std::vector<std::string>> Remotes::Reach() {
  // Short: the name of a Unix socket has 107 characters at most.
  char name[] = "/tmp/oos-ssh-XXXXXX";
  if (mkdtemp(name) == nullptr) return core::Fail(core::ErrorCode::kIo, "cannot make a folder in /tmp");
  folder_ = name;
  for (std::size_t i = 0; i < hosts_.size(); ++i) {
    auto master = StartMaster(i);
    if (!master) return tl::unexpected(master.error());
    masters_.push_back(std::move(*master));
  }
  std::vector<std::string> complaints;
  const std::int64_t deadline_ns = In_ns(kConnectPatience_s);
  for (std::size_t i = 0; i < hosts_.size(); ++i) {
    PipedChild& master = *masters_[i];
    std::error_code error;
    while (!std::filesystem::exists(Socket(i), error) && !master.has_ended() && core::MonotonicNow_ns() < deadline_ns) {
      master.Poll();
      WaitForAny({&master}, 5);
    }
    is_reached_.push_back(std::filesystem::exists(Socket(i), error));
    if (is_reached_.back()) continue;
    complaints.push_back("host " + hosts_[i].name + " (" + hosts_[i].address +
                         ") does not let us in: " + (master.err().empty() ? "no answer" : LastLine(master.err())) +
                         "; try: ssh " + hosts_[i].address);
  }
  return complaints;
}

std::vector<std::string> Remotes::Ssh(std::size_t host) const {
  // Only through the open connection: ssh must not make one of its own.
  return {"ssh",
          "-F",
          "none",
          "-S",
          Socket(host).string(),
          "-o",
          "ControlMaster=no",
          "-o",
          "ProxyCommand=false",
          "-o",
          "BatchMode=yes",
          "-T",
          "--",
          hosts_[host].address};
}

std::vector<Answer> Remotes::RunAll(const std::vector<std::string>& scripts, double patience_s) {
  std::vector<std::unique_ptr<PipedChild>> children(scripts.size());
  std::vector<PipedChild*> started;
  for (std::size_t i = 0; i < scripts.size(); ++i) {
    if (scripts[i].empty()) continue;
    auto words = Ssh(i);
    words.insert(words.end(), {"sh", "-s"});
    auto child = PipedChild::Start(words);
    if (!child) continue;
    (*child)->Write(scripts[i]);
    (*child)->CloseInput();
    started.push_back(child->get());
    children[i] = std::move(*child);
  }
  process::Finish(started, patience_s);
  std::vector<Answer> answers;
  for (std::size_t i = 0; i < scripts.size(); ++i) {
    if (scripts[i].empty()) {
      answers.push_back({0, "", ""});
    } else {
      answers.push_back(children[i] ? process::AnswerOf(*children[i]) : Answer{127, "", "cannot start ssh"});
    }
  }
  return answers;
}

Answer Remotes::Run(std::size_t host, const std::string& script, double patience_s) {
  std::vector<std::string> scripts(hosts_.size());
  scripts[host] = script;
  return RunAll(scripts, patience_s)[host];
}

core::Result<std::unique_ptr<PipedChild>> Remotes::Open(std::size_t host, const std::string& command) {
  auto words = Ssh(host);
  words.push_back(command);
  return PipedChild::Start(words);
}

std::vector<std::string> Remotes::Rsync(std::size_t host) const {
  const std::string ssh =
      "ssh -F none -S " + Socket(host).string() + " -o ControlMaster=no -o ProxyCommand=false -o BatchMode=yes";
  return {"rsync", "-a", "--timeout=60", "-e", ssh};
}

std::string Remotes::Target(std::size_t host, const std::string& path) const {
  return hosts_[host].address + ":" + path;
}

}  // namespace oos
