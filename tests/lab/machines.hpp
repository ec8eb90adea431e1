#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tools/process/piped_child.hpp"

namespace system_tests {

// Machines for tests, made of namespaces by the script beside this file: alpha, beta, gamma, ... at 10.77.0.11 and on.
// What is launched here stands in their network, at 10.77.0.1. All is gone when this object is, or the test.
class Machines {
 public:
  // What this computer lacks for it; empty: nothing.
  static std::string WhyNot();

  explicit Machines(const std::vector<std::string>& names);
  ~Machines();

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  // The words that run a command where the launcher stands.
  [[nodiscard]] std::vector<std::string> AtLauncher(std::vector<std::string> words) const;
  // The words that run a command on a machine, not over ssh.
  [[nodiscard]] std::vector<std::string> On(const std::string& name, std::vector<std::string> words) const;
  // The words that run a command in its network only.
  [[nodiscard]] std::vector<std::string> InNetworkOf(const std::string& name, std::vector<std::string> words) const;
  // Command lines of all processes of the machine but its first one and sshd.
  [[nodiscard]] std::vector<std::string> ProcessesOf(const std::string& name) const;

 private:
  std::filesystem::path folder_;
  std::unique_ptr<process::PipedChild> keeper_;
};

}  // namespace system_tests
