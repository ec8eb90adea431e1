#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/messages/device.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"
#include "view/arm_posture.hpp"
#include "view/choices.hpp"
#include "view/contact_marks.hpp"
#include "view/scene.hpp"
#include "view/scene_history.hpp"
#include "view/step_goals.hpp"

namespace view {

// Figures for the line of text with the current latency.
struct LiveFigures {
  double frames_per_s = 0.0;
  double render_scale = 1.0;  // of the picture's width and height
  double t2_state_ms = 0.0;   // recent mean; 0: none yet
  double t2_image_ms = 0.0;
  std::uint64_t dropped = 0;
};

// The scene, built from a scenario and then updated by each message that comes from the bus. Deterministic: the same
// messages in the same order give the same scene. Not thread-safe.
class SceneMirror {
 public:
  explicit SceneMirror(const scene::Scenario& scenario);

  // Poses of bodies that physics_node owns, and the two traces. Bodies unknown to the scenario are ignored.
  void Apply(const core::PhysicsState& state);
  // The hand's parts at the coupling pose X_WC [VR-OOS, Eq. 3-5], not at the device's pose X_WD.
  void Apply(const core::HapticProxy& proxy);
  // The felt force in the text: all that is sent to the role's device. None after kContactAge_ns without a command.
  void Apply(const core::DeviceCommand& command, std::int64_t now_ns);
  // A device that is a robot, as an overlay; none after kContactAge_ns without a message.
  void Apply(const core::DeviceJoints& joints, std::int64_t now_ns);
  // A tactile device, as a line of text and a ring round its body; none after kContactAge_ns without a message.
  void Apply(const core::TactileState& state, std::int64_t now_ns);
  // How many pairs touch, and the deepest, as text. `source`: of the matrix, 0 or 1. None of a source after
  // kContactAge_ns without a matrix.
  void Apply(const core::CollisionMatrix& matrix, std::size_t source, std::int64_t now_ns);
  // The margin of each hand's coupling in the text: the stiffness that the delay of its loop allows, over its own. The
  // course of t1. What muscles tell. Where a person who steers goes next.
  void ApplyBridge(const core::Figures& figures);
  // A device that is not there, in red: silent, gone, hung or broken, and why.
  void Apply(const core::DeviceHealth& health);
  // The course of late cycles.
  void ApplyHaptic(const core::Figures& figures);
  // Nodes of an object's sheet. Ignored when their number is not the scenario's.
  void Apply(const core::SheetState& sheet);
  // Arrows of one pair, by the set's pair_index. They stay until the pair's next set, at most kContactAge_ns.
  void Apply(const core::ContactSet& contacts, std::int64_t now_ns);
  // Lamps' colours, step, hint, end.
  void Apply(const core::LogicStatus& status);
  void Apply(const LiveFigures& figures);
  // What is shown from the next Refresh on.
  void Choose(const Choices& choices) { choices_ = choices; }
  [[nodiscard]] const Choices& choices() const { return choices_; }

  // Keeps what overlays show of the past. Refresh does it, too; who refreshes seldom calls it in between.
  void Remember(std::int64_t now_ns) { history_.Take(scene_, now_ns); }

  // Recomputes overlays and lines of text from the newest poses; drops pairs without a set for kContactAge_ns. Call it
  // before reading the scene.
  void Refresh(std::int64_t now_ns);

  [[nodiscard]] const Scene& scene() const { return scene_; }

  // Chosen for the eye, without a study. 100 ms is longer than any pause between the sets of a running pair, and short
  // enough that an arrow does not outlive a node that has ended.
  static constexpr std::int64_t kContactAge_ns = 100'000'000;
  // A hand's phantom is shown where the device is at least so far from the tool: below, the two look like one.
  static constexpr double kPhantom_m = 0.001;
  static constexpr double kPhantom_rad = 0.02;
  static constexpr float kSeeThrough = 0.3f;  // opacity of an object that is transparent by choice

 private:
  struct PairContacts {
    core::ContactSet set;
    std::int64_t received_ns = 0;
    bool is_known = false;
  };

  struct Arm {
    ArmPosture posture;
    int role = -1;
    core::Pose X_PalmF;
    std::size_t first = 0;  // instance of its first link
  };

  void TakeGuides(const core::Figures& figures);
  void AddScenery(Assets* assets);
  void AddSkins(Assets* assets);
  void MoveArms();
  void MoveHand(int role, const core::Pose& X_WD, const core::Pose& X_WC, double opening_m);
  void ShowObjects();
  void AddOverlays(std::int64_t now_ns);
  void AddContacts(std::int64_t now_ns);
  void AddFeltForces(std::int64_t now_ns);
  void AddPhantoms();
  void AddAxes();
  void WriteMatrix(std::int64_t now_ns);
  void WriteSelected(std::int64_t now_ns);
  [[nodiscard]] std::string LineOf(const core::Collision& collision) const;
  void AddTactiles(std::int64_t now_ns);
  void WriteTexts(std::int64_t now_ns);
  void WriteForces(std::int64_t now_ns);
  void WriteMargins();
  void WriteMuscles();
  void WriteCollisions(std::int64_t now_ns);

  scene::Scenario scenario_;
  space::Observer observer_;
  Scene scene_;
  std::vector<core::Pose> X_WH_;  // per object: the pose for contact gaps (a hand part: at X_WD)
  std::vector<PairContacts> pairs_;
  std::vector<Arm> arms_;
  std::vector<std::uint16_t> sheet_objects_;  // index of each sheet's object
  core::LogicStatus status_;
  int hinted_ = -1;  // object that the hint is about
  LiveFigures figures_;
  struct FeltForce {
    core::Wrench F_Do_W;
    std::int64_t received_ns = 0;
  };
  std::vector<FeltForce> felt_;  // per role
  struct Robot {
    core::DeviceJoints joints;
    std::int64_t received_ns = 0;
  };
  std::vector<Robot> robots_;  // per role; without joints: none
  struct TactileDevice {
    core::TactileState state;
    std::int64_t received_ns = 0;
    bool is_known = false;
  };
  std::vector<TactileDevice> tactiles_;  // of the scenario
  struct Matrix {
    core::CollisionMatrix matrix;
    std::int64_t received_ns = 0;
  };
  std::array<Matrix, 2> matrices_;
  std::vector<double> margins_;  // per role; 0: not measured
  std::vector<std::optional<double>>
      muscles_;                        // per role: share of the strongest grip, below zero: faults; none: no muscles
  std::vector<std::string> troubles_;  // per role: what is wrong with its device; empty: nothing
  std::string badge_;
  Choices choices_;
  SceneHistory history_;
  std::map<std::string, std::vector<StepGoal>> step_goals_;  // by step
  std::vector<bool> has_mesh_;                               // per object
};

}  // namespace view
