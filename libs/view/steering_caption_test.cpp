#include "view/steering_caption.hpp"

#include <gtest/gtest.h>

#include "view/hand_steering.hpp"

namespace view {
namespace {

// One hand at the origin, seen from somewhere.
struct Bench {
  scene::Scenario scenario;
  Scene scene;
  SteeringState state;
  scene::Camera camera;

  Bench() {
    scenario.force_cap_N = 40.0;
    scenario.devices.resize(1);
    scenario.devices[0].role = "right";
    scenario.devices[0].palm = 0;
    scene.instances.resize(1);
    scene.felt_N = {10.0};
    scene.guides.resize(1);
    camera.eye_m = {0.7, -1.1, 0.4};
    camera.target_m = {0, 0, 0};
    state.shows_next = true;
  }
  std::string Next() {
    scene.texts.clear();
    DescribeSteering(scenario, state, camera, &scene);
    for (const TextLine& line : scene.texts) {
      if (line.text.starts_with("next: ")) return line.text.substr(6);
    }
    return "";
  }
};

TEST(SteeringCaption, SaysWhichHandWhatItDoesAndFeels) {
  Bench bench;
  bench.state.shows_next = false;
  bench.state.input.is_held = true;
  bench.state.input.closing = 1.0;
  EXPECT_EQ(bench.Next(), "");
  EXPECT_EQ(bench.scene.texts.front().text, "hand right: held, jaws closing   [||||||..................] 10 N");
}

// What a key does to the hand, the caption undoes by the same word: the sum of both is nothing.
TEST(SteeringCaption, NamesTheKeyThatBringsTheHandThere) {
  struct Key {
    glm::dvec3 push, turn;
    const char* word;
  };
  const Key keys[] = {{{1, 0, 0}, {}, "right 15 mm"},       {{0, -1, 0}, {}, "down 15 mm"},
                      {{0, 0, 1}, {}, "away 15 mm"},        {{}, {0, 1, 0}, "Ctrl: right 4.6 deg"},
                      {{}, {-1, 0, 0}, "Ctrl: up 4.6 deg"}, {{}, {0, 0, -1}, "Ctrl: near 4.6 deg"}};
  for (const Key& key : keys) {
    Bench bench;
    HandSteering steering;
    SteeringWish wish;
    wish.is_held = true;
    wish.push = key.push;
    wish.turn = key.turn;
    const core::HandInput& moved = steering.Update(wish, bench.camera, 720.0, {0, 0, 0}, 0.1);
    bench.scene.guides[0] = {core::GuideKind::kMove, moved.moved_W_m, moved.turned_W_rad};
    EXPECT_EQ(bench.Next(), key.word);
    EXPECT_EQ(bench.scene.lines.size(), 1U);
  }
}

TEST(SteeringCaption, SaysWhatTheJawsDoAndWhenThereIsNothingToDo) {
  Bench bench;
  for (const auto& [kind, text] : {std::pair{core::GuideKind::kClose, "close the jaws"},
                                   {core::GuideKind::kOpen, "open the jaws"},
                                   {core::GuideKind::kWait, "wait"},
                                   {core::GuideKind::kNone, "the hand is not needed"},
                                   {core::GuideKind::kMove, "hold still"}}) {
    bench.scene.guides[0] = {kind, glm::dvec3(0.0), glm::dvec3(0.0)};
    EXPECT_EQ(bench.Next(), text);
  }
}

}  // namespace
}  // namespace view
