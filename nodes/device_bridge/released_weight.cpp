#include "nodes/device_bridge/released_weight.hpp"

#include <algorithm>

#include "collision/load_masses.hpp"

namespace device_bridge {
namespace {

// Mass and its centre, as the weight depends on no more.
void AddSheet(const scene::Sheet& sheet, physics::MassProperties* of) {
  const double sheet_kg = sheet.density_kg_per_m2 * sheet.size_x_m * sheet.size_y_m;
  const double sum_kg = of->mass_kg + sheet_kg;
  of->p_OCm_m = (of->mass_kg * of->p_OCm_m + sheet_kg * sheet.X_OS.translation) / sum_kg;
  of->mass_kg = sum_kg;
}

}  // namespace

core::Result<ReleasedWeight> ReleasedWeight::Create(const scene::Scenario& scenario) {
  ReleasedWeight weight;
  weight.gravity_W_m_per_s2_ = scenario.gravity_m_per_s2;
  if (scenario.gravity_m_per_s2 == glm::dvec3(0.0)) return weight;
  auto masses = collision::LoadMasses(scenario);
  if (!masses) return tl::unexpected(masses.error());
  weight.masses_ = std::move(*masses);
  for (std::size_t i = 0; i < weight.masses_.size(); ++i) {
    const scene::Object& object = scenario.objects[i];
    if (object.owner != scene::Owner::kPhysics || !object.sheet || !object.sheet->is_active) continue;
    AddSheet(*object.sheet, &weight.masses_[i]);
  }
  return weight;
}

// -sum m g . c, of the centres of mass c.
double ReleasedWeight::PotentialEnergy_J(const core::PhysicsState& state) const noexcept {
  double energy_J = 0.0;
  for (const core::BodyState& body : state.bodies) {
    if (body.object >= masses_.size()) continue;
    const physics::MassProperties& mass = masses_[body.object];
    energy_J -= mass.mass_kg * glm::dot(gravity_W_m_per_s2_, body.X_WO * mass.p_OCm_m);
  }
  return energy_J;
}

void ReleasedWeight::Update(const core::PhysicsState& state) noexcept {
  if (masses_.empty()) return;
  const double now_J = PotentialEnergy_J(state);
  if (!has_begun_) start_J_ = before_J_ = now_J;
  has_begun_ = true;
  constexpr double kLead_ticks = 3.0;  // a state is up to a tick under way, and the grasp's spring is behind the hand
  energy_J_ = start_J_ - now_J + kLead_ticks * std::max(0.0, before_J_ - now_J);
  before_J_ = now_J;
}

double ReleasedWeight::energy_J() const {
  return std::max(0.0, energy_J_);
}

}  // namespace device_bridge
