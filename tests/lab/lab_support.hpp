#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "tests/lab/machines.hpp"

namespace system_tests {

// Programs with a sanitizer cook and start up that many times more slowly.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr double kSlowness = 5.0;
#else
constexpr double kSlowness = 1.0;
#endif

// Waits until the child has printed `text`; false if it ends or does not within `patience_s`.
inline bool WaitFor(process::PipedChild* child, const std::string& text, double patience_s = 90.0) {
  const std::int64_t deadline_ns = core::MonotonicNow_ns() + static_cast<std::int64_t>(kSlowness * patience_s * 1e9);
  while (core::MonotonicNow_ns() < deadline_ns) {
    child->Poll();
    if (child->out().find(text) != std::string::npos) return true;
    if (child->has_ended()) return false;
    process::WaitForAny({child}, 50);
  }
  return false;
}

// Tests that launch on three machines, which exist as long as the suite.
class LabTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (why_not_ = Machines::WhyNot(); why_not_.empty()) {
      machines_ = std::make_unique<Machines>(std::vector<std::string>{"alpha", "beta", "gamma"});
    }
  }
  static void TearDownTestSuite() { machines_.reset(); }
  void SetUp() override {
    if (!why_not_.empty()) GTEST_SKIP() << why_not_;
  }

  static std::string FirstWord(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string word;
    in >> word;
    return word;
  }
  // The machine's CLOCK_MONOTONIC minus ours [ns], exactly: both derive from the kernel's one clock.
  static std::int64_t ClockOf(const std::string& machine) {
    std::ifstream in("/proc/" + FirstWord(machines_->folder() / (machine + ".pid")) + "/timens_offsets");
    std::string clock;
    std::int64_t seconds = 0, nanoseconds = 0;
    in >> clock >> seconds >> nanoseconds;
    return seconds * core::kNanosecondsPerSecond + nanoseconds;
  }

  static std::filesystem::path Folder(const std::string& name) {
    const auto folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "lab" / name;
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder.parent_path());
    return folder;
  }

  // Writes a lab file; `more` is added to every host, `hosts` maps each node to its host.
  static std::string WriteLab(const std::string& name, const std::map<std::string, std::string>& hosts,
                              const std::string& more = "", const std::string& lab_attributes = "") {
    const std::filesystem::path file = Folder(name + ".xml");
    std::ofstream out(file);
    out << "<lab name=\"" << name << "\" " << lab_attributes << ">\n";
    const char* const names[] = {"alpha", "beta", "gamma"};
    for (int i = 0; i < 3; ++i) {
      out << "  <host name=\"" << names[i] << "\" address=\"10.77.0." << 11 + i << "\" ssh_config=\""
          << (machines_->folder() / "ssh_config").string() << "\" cache=\"" << VR_OOS_BINARY_DIR << "/lab/cooked\" "
          << (more.find("ssh_config") == std::string::npos ? more : "") << "/>\n";
    }
    out << "  <registry host=\"beta\"/>\n";
    for (const auto& [node, host] : hosts) out << "  <node name=\"" << node << "\" host=\"" << host << "\"/>\n";
    out << "</lab>\n";
    return file.string();
  }

  static std::map<std::string, std::string> OnThree() {
    return {{"device_bridge", "alpha"},
            {"haptic_node", "alpha"},
            {"physics_node", "beta"},
            {"logic_node", "beta"},
            {"visual_node", "gamma"}};
  }

  static std::vector<std::string> Oos(std::vector<std::string> words) {
    words.insert(words.begin(), std::string(VR_OOS_BINARY_DIR) + "/bin/oos");
    return machines_->AtLauncher(words);
  }
  static std::vector<std::string> Launch(const std::string& lab, std::vector<std::string> more) {
    more.insert(more.begin(), {"launch", std::string(VR_OOS_SOURCE_DIR) + "/scenarios/touch", "--lab", lab});
    return Oos(more);
  }
  static process::Answer Run(const std::vector<std::string>& words, double patience_s = 120.0) {
    const auto answer = process::RunHere(words, "", kSlowness * patience_s);
    if (!answer) ADD_FAILURE() << answer.error().detail;
    return answer ? *answer : process::Answer{};
  }

  static void WaitForEnd(process::PipedChild* child, double patience_s = 60.0) {
    const std::int64_t deadline_ns = core::MonotonicNow_ns() + static_cast<std::int64_t>(kSlowness * patience_s * 1e9);
    while (!child->has_ended() && core::MonotonicNow_ns() < deadline_ns) {
      process::WaitForAny({child}, 50);
      child->Poll();
    }
    EXPECT_TRUE(child->has_ended());
  }

  static void ExpectNothingIsLeft() {
    for (const char* name : {"alpha", "beta", "gamma"}) {
      EXPECT_EQ(machines_->ProcessesOf(name), std::vector<std::string>()) << name;
    }
  }

  inline static std::unique_ptr<Machines> machines_;
  inline static std::string why_not_;
};

}  // namespace system_tests
