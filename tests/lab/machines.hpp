#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tools/process/piped_child.hpp"

namespace system_tests {

// Machines for tests, made of namespaces by the script beside this file: alpha, beta, gamma, ... at 10.77.0.11 and on.
// The launcher is in their network, at 10.77.0.1. All of it is removed with this object, or when the test dies.
class Machines {
 public:
  // What this computer lacks to run the machines; empty if nothing.
  static std::string WhyNot();

  explicit Machines(const std::vector<std::string>& names);
  ~Machines();

  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  // The command line that runs a command in the launcher's network.
  [[nodiscard]] std::vector<std::string> AtLauncher(std::vector<std::string> words) const;
  // The command line that runs a command on a machine, without ssh.
  [[nodiscard]] std::vector<std::string> On(const std::string& name, std::vector<std::string> words) const;
  // The command line that runs a command in a machine's network, but otherwise on this computer.
  [[nodiscard]] std::vector<std::string> InNetworkOf(const std::string& name, std::vector<std::string> words) const;
  // Command lines of all processes of the machine but its first one and sshd.
  [[nodiscard]] std::vector<std::string> ProcessesOf(const std::string& name) const;

 private:
  std::filesystem::path folder_;
  std::unique_ptr<process::PipedChild> keeper_;
};

}  // namespace system_tests
