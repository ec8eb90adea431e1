// A person without a device: real X events in a real window under Xvfb, by a program that sees the window's captions
// and nothing else. The judge is the run itself.

#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <thread>

#include "scene/load_scenario.hpp"
#include "tests/person/person.hpp"
#include "tools/oos/run/session/session.hpp"

namespace person_tests {
namespace {

struct Played {
  bool is_over = false;  // for the person
  double seconds = 0.0;  // from the first look at the window
  oos::SessionOutcome outcome;
};

// Plays until the person sees the end, the run ends, or the time is up.
void Play(const std::string& name, double patience_s, const std::function<bool(const Sight&)>& is_over,
          Played* played) {
  Window window;
  ASSERT_TRUE(window.Open());
  auto reader = CaptionReader::Create();
  ASSERT_TRUE(reader);
  const auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / name);
  ASSERT_TRUE(scenario);
  std::atomic<int> interrupted{0};
  std::atomic<bool> is_ended{false};
  oos::SessionOptions options;
  options.out = std::filesystem::path(VR_OOS_BINARY_DIR) / "person" / name;
  std::filesystem::remove_all(options.out);
  options.program_folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
  options.hand = "pointer";
  options.duration_s = patience_s + 300.0;
  options.interrupted = &interrupted;
  options.say = [](const std::string& line) { std::printf("%s\n", line.c_str()); };
  std::thread person([&] {
    if (window.WaitForWindow(120.0)) {
      Person hand(&window, std::move(*reader));
      played->is_over = hand.Follow(patience_s, is_over, is_ended);
      played->seconds = hand.seconds();
    }
    interrupted = SIGINT;
  });
  const auto outcome = oos::RunSession(*scenario, options);
  is_ended = true;
  person.join();
  ASSERT_TRUE(outcome) << outcome.error().detail;
  played->outcome = *outcome;
  std::printf("%s: %.1f s\n", name.c_str(), played->seconds);
}

bool HasEvent(const oos::SessionOutcome& outcome, const std::string& name, const std::string& detail) {
  return std::any_of(outcome.events.begin(), outcome.events.end(),
                     [&](const core::Event& event) { return event.name == name && event.detail == detail; });
}

// The person closes the jaws on the tab; when the captions then speak of a way again, it holds it.
TEST(Person, GraspsTheCoversTabWithinAMinute) {
  if (const std::string missing = Window::MissingProgram(); !missing.empty()) GTEST_SKIP() << missing << " is missing";
  Played played;
  ASSERT_NO_FATAL_FAILURE(Play(
      "module_replacement", 60.0, [](const Sight& seen) { return seen.is_closing && seen.way_mm() > 0.0; }, &played));
  EXPECT_TRUE(played.is_over);
  EXPECT_TRUE(HasEvent(played.outcome, "grasp_attached", "right cover"));
  EXPECT_LE(played.seconds, 60.0);
}

TEST(Person, PutsThePegIntoTheHoleWithinThreeMinutes) {
  if (const std::string missing = Window::MissingProgram(); !missing.empty()) GTEST_SKIP() << missing << " is missing";
  Played played;
  ASSERT_NO_FATAL_FAILURE(Play(
      "peg_in_hole", 180.0, [](const Sight&) { return false; }, &played));
  EXPECT_TRUE(played.outcome.is_final) << played.outcome.why;
  EXPECT_LE(played.seconds, 180.0);
}

}  // namespace
}  // namespace person_tests
