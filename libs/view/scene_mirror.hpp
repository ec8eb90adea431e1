#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/messages/haptic.hpp"
#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"
#include "view/scene.hpp"

namespace view {

// Figures for the line that tells the latency while it runs.
struct LiveFigures {
  double frames_per_s = 0.0;
  double t2_state_ms = 0.0;  // recent mean; 0: none yet
  double t2_image_ms = 0.0;
  std::uint64_t dropped = 0;
};

// The scene as the bus tells it: made from a scenario, then each message moves what it owns. Pure: the same messages in
// the same order give the same scene. One thread at a time.
class SceneMirror {
 public:
  explicit SceneMirror(const scene::Scenario& scenario);

  // Poses of bodies that physics_node owns, and the two traces. Bodies unknown to the scenario are passed over.
  void Apply(const core::PhysicsState& state);
  // The hand's parts at X_WC, where the contact holds the hand [VR-OOS, Eq. 3-5], not at X_WD, where the device is.
  void Apply(const core::HapticProxy& proxy);
  // Nodes of an object's sheet. One of another size than the scenario's is passed over.
  void Apply(const core::SheetState& sheet);
  // Arrows of one pair, by the set's pair_index. They stay until the pair says otherwise or falls silent.
  void Apply(const core::ContactSet& contacts, std::int64_t now_ns);
  // Lamps' colours, step, hint, end.
  void Apply(const core::LogicStatus& status);
  void Apply(const LiveFigures& figures);

  // Brings arrows and lines of text up to date: positions follow the bodies, pairs silent for kContactAge are dropped.
  // To be called before the scene is read.
  void Refresh(std::int64_t now_ns);

  [[nodiscard]] const Scene& scene() const { return scene_; }

  static constexpr std::int64_t kContactAge_ns = 100'000'000;
  // Length of an arrow: 15 mm for a touch, growing with the force, at most 150 mm.
  static constexpr double kArrowBase_m = 0.015;
  static constexpr double kArrowPerNewton_m = 0.004;
  static constexpr double kArrowMax_m = 0.15;
  static constexpr double kPatch_m = 0.03;  // contact points nearer than this share an arrow if they push alike

 private:
  struct PairContacts {
    core::ContactSet set;
    std::int64_t received_ns = 0;
    bool is_known = false;
  };

  void MoveHand(int role, const core::Pose& X_WD, const core::Pose& X_WC, double opening_m);
  void AddArrows(const PairContacts& contacts);
  void AddArrow(const glm::dvec3& p_W, const glm::dvec3& direction_W, double force_N);
  void WriteTexts();

  scene::Scenario scenario_;
  Scene scene_;
  std::vector<core::Pose> X_WH_;  // per object: pose that its contacts are computed with (a hand part: at X_WD)
  std::vector<PairContacts> pairs_;
  std::vector<std::uint16_t> sheet_objects_;  // object of each of the scene's sheets
  core::LogicStatus status_;
  LiveFigures figures_;
  double felt_force_N_ = 0.0;
  std::string badge_;
};

}  // namespace view
