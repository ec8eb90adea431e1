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

// Carries out one step of all sheets: at once, or on a thread of its own.
class SheetRunner {
 public:
  virtual ~SheetRunner() = default;
  virtual void Start(void (*step)(void*), void* context) = 0;
  [[nodiscard]] virtual bool IsIdle() const = 0;  // what the step wrote can be read
  virtual void WaitUntilIdle() = 0;
};

// The sheets of a scenario beside its world, at their own rate: every kPeriod_ticks they are told where bodies and
// hands are and make one step, whose forces act from the next period on. So a tick never waits for a sheet, and the
// result does not depend on when within the period the step was carried out. When it was not done in time the old
// forces stay and the period is counted as late; a runner that steps at once is never late.
//
// Sheets touch hands where these are drawn, at the coupling pose X_WC: there they do not reach into parts.
// A sheet that is asleep is not stepped, pulls at nothing and costs nothing.
class SheetKeeper {
 public:
  static constexpr std::uint64_t kPeriod_ticks = 2;
  static constexpr double kPinch_m = 0.003;  // jaws this near to the sheet's faces pinch it
  static constexpr double kLoose_m = 0.006;  // and this far let go

  // `options` say where distance fields of the parts are cached. Errors: file, line and what to do.
  static core::Result<std::unique_ptr<SheetKeeper>> Create(const scene::Scenario& scenario,
                                                           const std::vector<physics::MassProperties>& mass_of_object,
                                                           BuiltWorld* built, const collision::Options& options,
                                                           core::ParallelFor* workers);
  ~SheetKeeper();
  SheetKeeper(const SheetKeeper&) = delete;
  SheetKeeper& operator=(const SheetKeeper&) = delete;

  // Null: steps are made at once. Must outlive the keeper.
  void set_runner(SheetRunner* runner) { runner_ = runner; }

  // Before the world's step of this tick. `is_hand_full`: per role, the jaws hold an object.
  void Step(std::uint64_t tick, const Inputs& inputs, const std::array<bool, kMaxRoles>& is_hand_full);

  // Force of sheets on a hand about a point, from contact and pinching.
  [[nodiscard]] core::Wrench ForceOnHand(std::size_t role, const glm::dvec3& p_WDo) const;
  // Object whose sheet the role's jaws pinch; kNone.
  [[nodiscard]] int pinched_by(std::size_t role) const { return pinched_[role]; }

  void SetActive(int object, bool is_active);
  void SetReleaseForce(std::size_t mechanism, double release_force_N);

  [[nodiscard]] std::size_t num_sheets() const { return sheets_.size(); }
  [[nodiscard]] int object(std::size_t sheet) const { return sheets_[sheet].object; }
  [[nodiscard]] bool is_active(std::size_t sheet) const { return sheets_[sheet].is_active; }
  // Where its nodes were at the end of the newest step that was taken over; the header is left alone.
  void FillState(std::size_t sheet, std::uint64_t tick, core::SheetState* state) const;
  [[nodiscard]] std::uint64_t num_steps() const { return num_steps_; }
  [[nodiscard]] std::uint64_t num_late() const { return num_late_; }

  [[nodiscard]] bool is_idle() const { return runner_ == nullptr || runner_->IsIdle(); }  // no step is under way
  // Between ticks; waits for a step under way.
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
    bool has_stepped = false;  // since its results were taken over
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
  void TakeResults();
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
