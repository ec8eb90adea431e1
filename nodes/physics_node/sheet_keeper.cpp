#include "nodes/physics_node/sheet_keeper.hpp"

#include <algorithm>
#include <utility>

#include "core/clock.hpp"

namespace physics_node {
namespace {

// Half sizes of the gripper's pads along y and z of the palm's frame, about its origin. From
// scenarios/parts/gripper.scad (pad 20 x 15 mm).
constexpr double kPadHalfWidth_m = 0.010;
constexpr double kPadHalfHeight_m = 0.0075;

}  // namespace

SheetKeeper::SheetKeeper(const scene::Scenario& scenario, BuiltWorld* built)
    : scenario_(scenario), built_(built), loads_(scenario.objects.size()) {
  pinched_.fill(kNone);
  for (std::size_t role = 0; role < scenario.devices.size() && role < kMaxRoles; ++role) {
    hands_[role] = {scenario.devices[role].X_WD_start, scenario.devices[role].opening_start_m};
  }
}

SheetKeeper::~SheetKeeper() {
  if (runner_ != nullptr) runner_->WaitUntilIdle();
}

void SheetKeeper::Step(std::uint64_t tick, const Inputs& inputs, const std::array<bool, kMaxRoles>& is_hand_full) {
  if (tick % kPeriod_ticks != 0) return;
  if (runner_ != nullptr && !runner_->IsIdle()) {
    ++num_late_;
    return;
  }
  ApplyResults();
  for (const core::HapticProxy& proxy : inputs.proxies) {
    if (proxy.role_index >= kMaxRoles || proxy.header.sequence == 0) continue;
    hands_[proxy.role_index] = {{glm::normalize(proxy.X_WC.rotation), proxy.X_WC.translation}, proxy.opening_m};
  }
  bool is_any_active = false;
  for (Sheet& sheet : sheets_) {
    if (!sheet.is_active) {
      if (!sheet.is_resting) sheet.cloth->Rest();
      sheet.is_resting = true;
      continue;
    }
    sheet.is_resting = false;
    is_any_active = true;
    Place(&sheet);
    Pinch(&sheet, is_hand_full);
    for (const Hooks& hooks : sheet.hooks) sheet.cloth->SetReleaseForce(hooks.bond, hooks.release_force_N);
    sheet.has_stepped = true;
  }
  if (!is_any_active) return;
  ++num_steps_;
  if (runner_ == nullptr) {
    Run();
  } else {
    runner_->Start([](void* keeper) { static_cast<SheetKeeper*>(keeper)->Run(); }, this);
  }
}

void SheetKeeper::Run() {
  for (Sheet& sheet : sheets_) {
    if (sheet.has_stepped) sheet.cloth->Step(static_cast<double>(kPeriod_ticks) * core::kTick_s);
  }
}

void SheetKeeper::ApplyResults() {
  std::fill(loads_.begin(), loads_.end(), core::Wrench{});
  pinched_.fill(kNone);
  for (Sheet& sheet : sheets_) {
    sheet.F_Hand_W.fill({});
    if (!sheet.has_stepped) continue;  // inactive
    sheet.has_stepped = false;
    const physics::Cloth& cloth = *sheet.cloth;
    for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
      const int body = sheet.body_of_object[i];
      if (body == kNone) continue;
      const scene::Object& object = scenario_.objects[i];
      if (object.owner == scene::Owner::kPhysics) {
        loads_[i] += cloth.MeanWrenchOn(body, built_->world->X_WO(built_->body_of_object[i]).translation);
      } else if (object.owner == scene::Owner::kHand && object.role < static_cast<int>(kMaxRoles)) {
        const auto role = static_cast<std::size_t>(object.role);
        sheet.F_Hand_W[role] += cloth.MeanWrenchOn(body, glm::dvec3(0.0));
        if (cloth.num_gripped(body) > 0) pinched_[role] = sheet.object;
      }
    }
    for (const Hooks& hooks : sheet.hooks) {
      hooks.shown->Set(cloth.held(hooks.bond), glm::length(cloth.BondForce_W(hooks.bond)));
    }
    for (std::size_t i = 0; i < sheet.p_W.size(); ++i) sheet.p_W[i] = glm::vec3(cloth.positions_W()[i]);
  }
  for (std::size_t i = 0; i < loads_.size(); ++i) {
    if (scenario_.objects[i].owner == scene::Owner::kPhysics) {
      built_->world->SetLoad(built_->body_of_object[i], loads_[i]);
    }
  }
}

// Sets the current poses of the bodies: those that physics moves start the step there, hands reach theirs at its end.
void SheetKeeper::Place(Sheet* sheet) {
  for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
    const int body = sheet->body_of_object[i];
    if (body == kNone) continue;
    const scene::Object& object = scenario_.objects[i];
    if (object.owner == scene::Owner::kPhysics) {
      const int moved = built_->body_of_object[i];
      sheet->cloth->SetBody(body, built_->world->X_WO(moved), built_->world->V_WO(moved));
    } else if (object.owner == scene::Owner::kHand && object.role < static_cast<int>(kMaxRoles)) {
      const Hand& hand = hands_[static_cast<std::size_t>(object.role)];
      sheet->cloth->SetBody(body, scene::PartPose(object.part, hand.X_WC, hand.opening_m));
    }
  }
}

// Jaws that have closed on the sheet and on no object grip the nodes between their pads.
void SheetKeeper::Pinch(Sheet* sheet, const std::array<bool, kMaxRoles>& is_hand_full) {
  for (std::size_t role = 0; role < scenario_.devices.size() && role < kMaxRoles; ++role) {
    const int palm = scenario_.devices[role].palm;
    if (palm < 0 || scenario_.devices[role].jaw_left < 0) continue;
    const int body = sheet->body_of_object[static_cast<std::size_t>(palm)];
    if (body == kNone) continue;
    const double gap_m = hands_[role].opening_m - sheet->params->thickness_m;
    int& count = sheet->num_pinched[role];
    if (count > 0 && (gap_m > kLoose_m || is_hand_full[role])) {
      sheet->cloth->Release(body);
      count = 0;
    }
    if (count > 0 || gap_m > kPinch_m || is_hand_full[role]) continue;
    const glm::dvec3 half(0.5 * hands_[role].opening_m + kPinch_m, kPadHalfWidth_m, kPadHalfHeight_m);
    count = sheet->cloth->CountInside(body, -half, half);
    if (count == 0) continue;
    const physics::ClothBondParams grip{body, sheet->params->grip_stiffness_N_per_m / count,
                                        sheet->params->grip_damping_N_s_per_m / count};
    count = sheet->cloth->Grip(grip, -half, half);
  }
}

core::Wrench SheetKeeper::ForceOnHand(std::size_t role, const glm::dvec3& p_WDo) const {
  core::Wrench F_Do_W;
  for (const Sheet& sheet : sheets_) F_Do_W += core::ShiftWrench(sheet.F_Hand_W[role], -p_WDo);
  return F_Do_W;
}

void SheetKeeper::SetActive(int object, bool is_active) {
  for (Sheet& sheet : sheets_) {
    if (sheet.object == object) sheet.is_active = is_active;
  }
}

void SheetKeeper::SetReleaseForce(std::size_t mechanism, double release_force_N) {
  for (Sheet& sheet : sheets_) {
    for (Hooks& hooks : sheet.hooks) {
      if (hooks.mechanism == mechanism) hooks.release_force_N = release_force_N;
    }
  }
}

void SheetKeeper::FillState(std::size_t index, std::uint64_t tick, core::SheetState* state) const {
  const Sheet& sheet = sheets_[index];
  state->object = static_cast<std::uint16_t>(sheet.object);
  state->tick = tick;
  state->num_columns = static_cast<std::uint16_t>(sheet.params->cells_x + 1);
  state->p_W.resize(sheet.p_W.size());
  std::copy(sheet.p_W.begin(), sheet.p_W.end(), state->p_W.begin());
}

void SheetKeeper::ExchangeState(physics::Checkpoint* checkpoint) {
  if (runner_ != nullptr) runner_->WaitUntilIdle();
  for (Sheet& sheet : sheets_) {
    sheet.cloth->ExchangeState(checkpoint);
    checkpoint->Exchange(&sheet.is_active);
    checkpoint->Exchange(&sheet.is_resting);
    checkpoint->Exchange(&sheet.has_stepped);
    checkpoint->Exchange(&sheet.F_Hand_W);
    checkpoint->Exchange(&sheet.num_pinched);
    for (Hooks& hooks : sheet.hooks) checkpoint->Exchange(&hooks.release_force_N);
    for (glm::vec3& p : sheet.p_W) checkpoint->Exchange(&p);
  }
  checkpoint->Exchange(&hands_);
  checkpoint->Exchange(&pinched_);
  checkpoint->Exchange(&num_steps_);
}

}  // namespace physics_node
