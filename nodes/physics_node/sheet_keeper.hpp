#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "collision/owned_world.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/physics.hpp"
#include "nodes/physics_node/build_world.hpp"
#include "nodes/physics_node/ports.hpp"
#include "physics/cloth/cloth.hpp"
#include "physics/cloth/cloth_hooks.hpp"

namespace physics_node {

// Runs one step of all sheets: at once, or on a thread of its own.
class SheetRunner {
 public:
  virtual ~SheetRunner() = default;
  virtual void Start(void (*step)(void*), void* context) = 0;
  [[nodiscard]] virtual bool IsIdle() const = 0;  // the step's results can be read
  virtual void WaitUntilIdle() = 0;
};

// Steps the sheets of a scenario beside its world, at their own rate: every kPeriod_ticks they get the poses of bodies
// and hands and make one step, whose forces act from the next period on. So a tick never waits for a sheet, and the
// result does not depend on when within the period the step runs. When a step is not finished in time, the old forces
// stay and the period is counted as late; a runner that steps at once is never late.
//
// Sheets touch hands at the coupling pose X_WC, where these do not penetrate parts. An inactive sheet is not stepped,
// exerts no forces and costs no time.
class SheetKeeper {
 public:
  // Chosen: twice the period halves the cost and doubles the delay of the sheets' forces. The gaps form a hysteresis.
  static constexpr std::uint64_t kPeriod_ticks = 2;
  static constexpr double kPinch_m = 0.003;  // jaws pinch the sheet when their gap to its faces is below this
  static constexpr double kLoose_m = 0.006;  // and release it above this

  // `options` give the cache for the parts' distance fields. Errors name file, line and remedy.
  static core::Result<std::unique_ptr<SheetKeeper>> Create(const scene::Scenario& scenario,
                                                           const std::vector<physics::MassProperties>& mass_of_object,
                                                           BuiltWorld* built, const collision::Options& options,
                                                           core::ParallelFor* workers);
  ~SheetKeeper();
  SheetKeeper(const SheetKeeper&) = delete;
  SheetKeeper& operator=(const SheetKeeper&) = delete;

  // Null: steps are made at once. Must outlive the keeper.
  void set_runner(SheetRunner* runner) { runner_ = runner; }

  // Call it before the world's step of the tick. `is_hand_full`: per role, the jaws hold an object.
  void Step(std::uint64_t tick, const Inputs& inputs, const std::array<bool, kMaxRoles>& is_hand_full);

  // Wrench of all sheets on a hand about a point in W, from contact and pinching.
  [[nodiscard]] core::Wrench ForceOnHand(std::size_t role, const glm::dvec3& p_WDo) const;
  // Object whose sheet the role's jaws pinch; kNone: none.
  [[nodiscard]] int pinched_by(std::size_t role) const { return pinched_[role]; }

  void SetActive(int object, bool is_active);
  void SetReleaseForce(std::size_t mechanism, double release_force_N);

  [[nodiscard]] std::size_t num_sheets() const { return sheets_.size(); }
  [[nodiscard]] int object(std::size_t sheet) const { return sheets_[sheet].object; }
  [[nodiscard]] bool is_active(std::size_t sheet) const { return sheets_[sheet].is_active; }
  // Nodes at the end of the newest finished step; does not change the header.
  void FillState(std::size_t sheet, std::uint64_t tick, core::SheetState* state) const;
  [[nodiscard]] std::uint64_t num_steps() const { return num_steps_; }
  [[nodiscard]] std::uint64_t num_late() const { return num_late_; }

  [[nodiscard]] bool is_idle() const { return runner_ == nullptr || runner_->IsIdle(); }  // no step is in progress
  // Between ticks; waits for a step in progress.
  void ExchangeState(physics::Checkpoint* checkpoint);

 private:
  struct Hooks {
    std::size_t mechanism = 0;
    int bond = 0;
    physics::ClothHooks* shown = nullptr;
    double release_force_N = 0.0;
  };
  struct Sheet {
    int object = kNone;
    const scene::Sheet* params = nullptr;
    std::unique_ptr<physics::Cloth> cloth;
    std::vector<int> body_of_object;  // of the cloth; kNone
    int ground = kNone;
    std::vector<Hooks> hooks;
    bool is_active = true;
    bool is_resting = false;
    bool has_stepped = false;  // since its results were applied
    std::vector<glm::vec3> p_W;
    std::array<core::Wrench, kMaxRoles> F_Hand_W;  // about the origin of W
    std::array<int, kMaxRoles> num_pinched{};
  };
  struct Hand {
    core::Pose X_WC;
    double opening_m = 0.0;
  };
  class Builder;

  explicit SheetKeeper(const scene::Scenario& scenario, BuiltWorld* built);
  void ApplyResults();
  void Place(Sheet* sheet);
  void Pinch(Sheet* sheet, const std::array<bool, kMaxRoles>& is_hand_full);
  void Run();

  const scene::Scenario& scenario_;
  BuiltWorld* built_;
  SheetRunner* runner_ = nullptr;
  std::vector<Sheet> sheets_;
  std::vector<core::Wrench> loads_;  // by object, about its mesh origin
  std::array<Hand, kMaxRoles> hands_;
  std::array<int, kMaxRoles> pinched_{};
  std::uint64_t num_steps_ = 0;
  std::uint64_t num_late_ = 0;
};

}  // namespace physics_node
