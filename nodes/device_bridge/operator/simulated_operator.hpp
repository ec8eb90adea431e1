#pragma once

#include <cstdint>
#include <vector>

#include "nodes/device_bridge/operator/operator_script.hpp"
#include "nodes/device_bridge/operator/perception.hpp"
#include "nodes/device_bridge/operator/script_sight.hpp"
#include "nodes/device_bridge/operator/stroke.hpp"
#include "nodes/device_bridge/random.hpp"

namespace device_bridge {

// Typical of people: visual correction after about 0.2 s, reaction to a felt force after about 0.15 s, tremor of 8 to
// 12 Hz and 0.1 to 0.2 mm, end-point errors of 5 to 10 % of a stroke's length [Woodworth 1899; Meyer et al. 1988]. The
// two speeds are assumed.
struct OperatorOptions {
  double visual_delay_s = 0.2;
  double reaction_s = 0.15;           // to a felt force
  double tremor_m = 0.00015;          // amplitude, 8 to 12 Hz; 0: none
  double end_point_error = -1.0;      // sd / length of a stroke; negative: drawn from 0.05 to 0.08 by the seed
  double turn_speed_rad_per_s = 1.5;  // peak of a stroke
  double opening_speed_m_per_s = 0.15;
};

enum class LineOutcome { kDone, kDistanceUsedUp, kAbandoned };

// Outcome of one line of the script, for the run's report.
struct LineRecord {
  int step = 0;  // index into the script
  int line = 0;  // in the file
  std::int64_t begin_ns = 0;
  std::int64_t end_ns = 0;
  int num_strokes = 0;
  LineOutcome outcome = LineOutcome::kDone;
};

// A SIMULATED human operator in closed loop: carries out the script's lines of the active procedure step. It sees the
// scene only through DelayedSight, feels forces only through DelayedTouch, and outputs only the targets of its hands'
// impedance; so it acts on the scene through the same force loop as a person.
//
// Movement: minimum-jerk strokes with an end-point error in proportion to their length, each followed by an observation
// and, while the seen error exceeds the tolerance, a corrective stroke [Woodworth 1899; Meyer et al. 1988; Flash and
// Hogan 1985]. When a push or a carried object is blocked, the hand searches in a spiral of at most 1.5 mm. While a
// device applies no force, its hand waits without pushing. The same seed and inputs give the same movement, bit for
// bit.
class SimulatedOperator {
 public:
  SimulatedOperator(const scene::Scenario& scenario, OperatorScript script, std::uint64_t seed,
                    const OperatorOptions& options);
  SimulatedOperator(const SimulatedOperator&) = delete;  // current_ points into script_
  SimulatedOperator& operator=(const SimulatedOperator&) = delete;

  // One tick. `felt` and `readings` are per role; `readings` enter only the delayed vision. Real-time: no allocation.
  void Step(const Inputs& inputs, const core::FixedVector<FeltForce, kMaxRoles>& felt,
            const core::FixedVector<DeviceReading, kMaxRoles>& readings) noexcept;

  // Sees and feels, but does nothing: another one moves the hands.
  void Watch(const Inputs& inputs, const core::FixedVector<FeltForce, kMaxRoles>& felt,
             const core::FixedVector<DeviceReading, kMaxRoles>& readings) noexcept;
  // Goes on from there, with the first line of the present step.
  void TakeUp(std::size_t role, const HandTarget& target) noexcept;

  [[nodiscard]] const HandTarget& target(std::size_t role) const { return hands_[role].target; }
  [[nodiscard]] const OperatorScript& script() const { return script_; }
  [[nodiscard]] const std::vector<LineRecord>& records() const { return records_; }
  [[nodiscard]] bool is_idle() const { return current_ == nullptr; }
  [[nodiscard]] bool is_searching() const { return is_searching_; }

 private:
  enum class Phase { kBegin, kStroke, kObserve, kPush, kRelax, kGrip, kWait };

  struct Hand {
    core::Pose X_WB;  // base of the target: without tremor and search
    core::Twist V_WB;
    Stroke stroke;
    double opening_from_m = 0.0;
    double opening_way_m = 0.0;
    double opening_duration_s = 0.0;
    double opening_elapsed_s = 0.0;
    double grip_strength_N = 20.0;
    double strongest_grip_N = 20.0;
    double grip_friction = 0.0;  // 0: grips with the strongest
    double search_gain = 0.0;    // 0 to 1, faded
    glm::dvec3 tremor_hz{10.0};
    glm::dvec3 tremor_phase_rad{0.0};
    HandTarget target;
    DelayedTouch touch;
    double stiffness_N_per_m = 800.0;
    double force_limit_N = 40.0;
    bool is_relaxed = false;  // because the device applies no force
    explicit Hand(double reaction_s) : touch(reaction_s) {}
  };

  void FollowStep(const Sighting* seen, std::int64_t now_ns) noexcept;
  void Abandon(std::int64_t now_ns) noexcept;
  void RelaxHand(Hand* hand, const FeltForce& felt) noexcept;
  void CarryOutLine(const Sighting& seen, std::int64_t now_ns, double dt_s) noexcept;
  void Move(const OperatorLine& line, const Sighting& seen, double dt_s) noexcept;
  void BeginStroke(const OperatorLine& line, const Aim& aim, bool is_first) noexcept;
  void Push(const OperatorLine& line, const Sighting& seen, const FeltForce& felt, double dt_s) noexcept;
  void EndPush(const OperatorLine& line, const FeltForce& felt) noexcept;
  void Grip(const OperatorLine& line, const FeltForce& felt, double dt_s) noexcept;
  void FollowLoad(Hand* hand, double dt_s) const noexcept;
  void EnterPhase(Phase phase) noexcept;
  void EndLine(LineOutcome outcome, std::int64_t now_ns) noexcept;
  void UpdateTarget(Hand* hand, double dt_s) noexcept;

  OperatorScript script_;
  OperatorOptions options_;
  Random random_;
  double end_point_error_ = 0.06;
  DelayedSight sight_;
  std::vector<Hand> hands_;

  std::int64_t last_ns_ = 0;
  bool has_started_ = false;
  double time_s_ = 0.0;  // since the first tick: the time of tremor and search
  int step_ = -1;
  std::size_t next_line_ = 0;
  const OperatorLine* current_ = nullptr;
  LineRecord record_;
  std::vector<LineRecord> records_;

  Phase phase_ = Phase::kBegin;
  double phase_s_ = 0.0;  // in this phase
  double line_s_ = 0.0;   // in this line
  LineOutcome outcome_ = LineOutcome::kDone;
  bool is_line_over_ = false;

  // reach and carry
  core::Pose X_WHand_before_;  // seen in the previous tick, for the seen speed
  std::int64_t seen_before_ns_ = 0;
  double seen_speed_m_per_s_ = 0.0;
  double within_s_ = 0.0;
  double best_error_m_ = 0.0;
  int num_in_vain_ = 0;

  // push
  double pushed_m_ = 0.0;
  double push_time_s_ = 0.0;
  glm::dvec3 p_push_begin_{0.0};
  double progress_m_ = 0.0;
  double stalled_s_ = 0.0;
  double used_up_s_ = 0.0;

  // search
  bool is_searching_ = false;
  double search_s_ = 0.0;
  glm::dvec3 search_normal_W_{0, 0, 1};
};

}  // namespace device_bridge
