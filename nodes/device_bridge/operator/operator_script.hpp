#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "scene/diagnostic.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// Script of the simulated operator: what it does in each procedure step. Format: scenarios/README.md, "operator.txt".

// Reference to a frame: `OBJECT.FRAME`, `OBJECT` for the mesh frame itself, or `hand` for the palm of the line's role.
struct FrameReference {
  int object = -1;
  bool is_hand = false;
  core::Pose X_OF;
};

enum class ConditionKind { kNone, kEngaged, kFree, kState, kHeld, kReleased };

struct Condition {
  ConditionKind kind = ConditionKind::kNone;
  int mechanism = -1;  // kEngaged, kFree, kState
  int state = 0;       // kState
  int object = -1;     // kHeld
};

enum class Verb { kReach, kCarry, kPush, kGrip, kWait };

struct OperatorLine {
  Verb verb = Verb::kWait;
  int role = 0;
  int line = 0;          // in the file
  FrameReference moved;  // carry: the held object's frame
  FrameReference goal;   // reach, carry
  core::Pose X_FG;       // offset and turn in the goal frame
  double speed_m_per_s = 0.25;
  double within_m = 0.003;
  glm::dvec3 direction_W{0.0};  // push, unit
  double distance_m = 0.0;
  double until_felt_N = 0.0;  // push; 0: not given
  Condition until;            // push, wait
  double opening_m = 0.0;     // grip
  double grip_strength_N = 20.0;
  double grip_friction = 0.0;  // no harder than what is felt asks for, with this friction at the fingers; 0: as given
  double seconds = 0.0;        // wait
};

struct OperatorStep {
  std::string name;
  int line = 0;
  std::vector<OperatorLine> lines;
};

struct OperatorScript {
  std::filesystem::path file;
  std::vector<OperatorStep> steps;
};

struct ParsedOperatorScript {
  OperatorScript script;
  std::vector<scene::Diagnostic> diagnostics;  // empty: the script is valid
};

// Parses a script. `step_names`: the procedure's steps, to check `step NAME`; empty: not checked.
ParsedOperatorScript ParseOperatorScript(std::string_view text, const std::filesystem::path& file,
                                         const scene::Scenario& scenario, const std::vector<std::string>& step_names);

// Ids of the states directly inside the `procedure` region, which are the steps of the report. Empty when the file
// cannot be read (logic_node reports why) or has no such region.
std::vector<std::string> ReadStepNames(const std::filesystem::path& procedure);

// The scenario's script; an empty one when the scenario names none. Error: kInvalidInput, with one line per diagnostic.
core::Result<OperatorScript> LoadOperatorScript(const scene::Scenario& scenario);

// All errors of the scenario's script, for `oos check`.
std::vector<scene::Diagnostic> CheckOperatorScript(const scene::Scenario& scenario);

}  // namespace device_bridge
