#include "physics/world.hpp"

#include <algorithm>
#include <cmath>

#include "core/hash.hpp"
#include "physics/engine/world_impl.hpp"

namespace physics {
World::World() : World(Options{}) {}

World::World(const Options& options) : impl_(std::make_unique<Impl>(options)) {
  BodyParams fixed;
  static_cast<void>(AddBody(fixed));  // cannot fail: a fixed body at the origin
}

World::~World() = default;

int World::world_body() const {
  return 0;
}

void World::SetKinematic(int index, const core::Pose& X_WO, const core::Twist& V_WO) {
  RigidBody& body = impl_->body(index);
  body.p_WCm = X_WO.translation;  // B = O for a body without mass
  body.R_WB = X_WO.rotation;
  body.v_WCm = V_WO.linear_m_per_s;
  body.w_W = V_WO.angular_rad_per_s;
}

void World::SetGravity(const glm::dvec3& gravity_W_m_per_s2) {
  impl_->gravity_W_m_per_s2 = gravity_W_m_per_s2;
}

void World::SetLoad(int index, const core::Wrench& F_Bo_W) {
  impl_->body(index).load_Bo_W = F_Bo_W;
}

void World::SetContactPlanes(int pair, const core::ContactSet& set) {
  impl_->pairs[static_cast<std::size_t>(pair)].feed.Set(set);
}

void World::SetContactWrench(int pair, const core::Wrench& F_So_W) {
  PairSlot& slot = impl_->pairs[static_cast<std::size_t>(pair)];
  slot.has_wrench = true;
  slot.F_So_W = F_So_W;
}

void World::ClearContact(int pair) {
  PairSlot& slot = impl_->pairs[static_cast<std::size_t>(pair)];
  slot.has_wrench = false;
  slot.feed.Clear();
}

void World::SetContactMuted(int pair, bool is_muted) {
  PairSlot& slot = impl_->pairs[static_cast<std::size_t>(pair)];
  slot.is_muted = is_muted;
  if (is_muted) slot.feed.Mute();
}

bool World::HasContactPlanes(int pair) const {
  return !impl_->pairs[static_cast<std::size_t>(pair)].feed.empty();
}

double World::SmallestGap_m(int pair) const {
  const PairSlot& slot = impl_->pairs[static_cast<std::size_t>(pair)];
  return slot.feed.SmallestGap(impl_->body(slot.sampled).X_WO(), impl_->body(slot.field).X_WO(), nullptr);
}

double World::SmallestGapAlong_m(int pair, const glm::dvec3& direction_W) const {
  const PairSlot& slot = impl_->pairs[static_cast<std::size_t>(pair)];
  return slot.feed.SmallestGap(impl_->body(slot.sampled).X_WO(), impl_->body(slot.field).X_WO(), nullptr, &direction_W);
}

double World::PressedRadius_m(int pair) const {
  const PairSlot& slot = impl_->pairs[static_cast<std::size_t>(pair)];
  return slot.feed.PressedRadius(impl_->body(slot.sampled).X_WO(), impl_->body(slot.field).X_WO());
}

glm::dvec3 World::DeepestPoint_W(int pair) const {
  const PairSlot& slot = impl_->pairs[static_cast<std::size_t>(pair)];
  glm::dvec3 p_W = impl_->body(slot.sampled).p_WCm;
  static_cast<void>(slot.feed.SmallestGap(impl_->body(slot.sampled).X_WO(), impl_->body(slot.field).X_WO(), &p_W));
  return p_W;
}

void World::Step(double dt_s) {
  Impl& w = *impl_;
  w.last_dt_s = dt_s;
  ++w.num_steps;
  for (RigidBody& body : w.bodies) body.Push();
  for (PairSlot& pair : w.pairs) {
    const core::Pose X_WS = w.body(pair.sampled).X_WO();
    const core::Pose X_WG = w.body(pair.field).X_WO();
    pair.report = ContactReport{};
    pair.report.smallest_gap_m = pair.feed.SmallestGap(X_WS, X_WG, nullptr);
    if (!pair.feed.empty() && !pair.is_muted && !pair.has_wrench) pair.feed.Inject(X_WS, X_WG, dt_s);
  }
  w.ApplyWrenches(dt_s);
  w.ApplyLoads(dt_s);
  w.ApplyWeights(dt_s);
  for (MechanismSlot& slot : w.mechanisms) {
    const BodyView parent = w.View(slot.parent);
    const BodyView child = w.View(slot.child);
    slot.mechanism->AdvanceChanges(parent, child, w.num_steps, dt_s);
    slot.mechanism->Prepare(parent, child, dt_s);
  }
  w.world.stepSimulation(dt_s, 0);  // 0: exactly one step; otherwise Bullet uses its own clock and drops time
  w.Collect(dt_s);
  for (RigidBody& body : w.bodies) {
    if (body.kind != BodyKind::kDynamic) continue;
    const glm::dvec3 p_Ns = body.momentum_Ns();
    const glm::dvec3 L_Nms = body.angular_momentum_Nms();
    body.Integrate(dt_s);
    body.account.Close(body.momentum_Ns() - p_Ns, body.angular_momentum_Nms() - L_Nms);
  }
}

std::uint64_t World::num_steps() const {
  return impl_->num_steps;
}

int World::FindTunable(int index, std::string_view name) const {
  const std::vector<Tunable>& tunables = mechanism(index).tunables();
  const auto found = std::find_if(tunables.begin(), tunables.end(), [&](const Tunable& t) { return name == t.name; });
  return found == tunables.end() ? -1 : static_cast<int>(found - tunables.begin());
}

bool World::CanChange(int index, int tunable, const Change& change) const {
  const std::vector<Tunable>& tunables = mechanism(index).tunables();
  if (tunable < 0 || static_cast<std::size_t>(tunable) >= tunables.size()) return false;
  if (!std::isfinite(change.value) || !std::isfinite(change.ramp_s) || change.ramp_s < 0.0) return false;
  return change.value >= 0.0 || tunables[static_cast<std::size_t>(tunable)].is_signed;
}

const ChangeReport& World::BeginChange(int index, int tunable, const Change& change) {
  MechanismSlot& slot = impl_->mechanisms[static_cast<std::size_t>(index)];
  return slot.mechanism->BeginChange(static_cast<std::size_t>(tunable), change, impl_->View(slot.parent),
                                     impl_->View(slot.child), impl_->num_steps + 1);
}

const ChangeReport& World::change_report(int index, int tunable) const {
  return mechanism(index).tunables()[static_cast<std::size_t>(tunable)].state.report;
}

double World::StoredEnergy_J(int index) const {
  const MechanismSlot& slot = impl_->mechanisms[static_cast<std::size_t>(index)];
  return slot.mechanism->StoredEnergy_J(impl_->View(slot.parent), impl_->View(slot.child));
}

core::Pose World::X_WO(int body) const {
  return impl_->body(body).X_WO();
}
core::Twist World::V_WO(int body) const {
  return impl_->body(body).V_WO();
}
BodyKind World::kind(int body) const {
  return impl_->body(body).kind;
}
std::size_t World::num_bodies() const {
  return impl_->bodies.size();
}
const ContactReport& World::contact(int pair) const {
  return impl_->pairs[static_cast<std::size_t>(pair)].report;
}
Mechanism& World::mechanism(int index) {
  return *impl_->mechanisms[static_cast<std::size_t>(index)].mechanism;
}
const Mechanism& World::mechanism(int index) const {
  return *impl_->mechanisms[static_cast<std::size_t>(index)].mechanism;
}

core::Wrench World::MechanismForceOnParent(int index, const glm::dvec3& p_WQ) const {
  core::Wrench F_Q_W;
  if (impl_->last_dt_s == 0.0) return F_Q_W;
  for (const Row& row : mechanism(index).rows()) {
    if (!row.is_active) continue;
    const glm::dvec3 force_W = -(row.impulse / impl_->last_dt_s) * row.linear_W;
    F_Q_W.force_N += force_W;
    F_Q_W.torque_Nm += glm::cross(row.p_W - p_WQ, force_W) - (row.impulse / impl_->last_dt_s) * row.angular_W;
  }
  return F_Q_W;
}

int World::parent_of(int mechanism) const {
  return impl_->mechanisms[static_cast<std::size_t>(mechanism)].parent;
}
int World::child_of(int mechanism) const {
  return impl_->mechanisms[static_cast<std::size_t>(mechanism)].child;
}

ImpulseBalance World::impulse_balance() const {
  ImpulseBalance balance;
  for (const RigidBody& body : impl_->bodies) {
    if (body.kind != BodyKind::kDynamic) continue;
    balance.linear_residual_Ns += glm::length(body.momentum_Ns() - body.start_p_Ns - body.impulses_Ns);
    balance.angular_residual_Nms +=
        glm::length(body.angular_momentum_Nms() - body.start_L_Nms - body.angular_impulses_Nms);
  }
  for (const ImpulseMagnitude& magnitude : impl_->magnitudes) {
    balance.linear_magnitude_Ns += magnitude.Ns;
    balance.angular_magnitude_Nms += magnitude.Nms;
  }
  return balance;
}

ImpulseBalance World::Impl::BalanceOf(ImpulseSource source) const {
  const auto at = static_cast<std::size_t>(source);
  ImpulseBalance balance{0.0, magnitudes[at].Ns, 0.0, magnitudes[at].Nms};
  for (const RigidBody& body : bodies) {
    balance.linear_residual_Ns += glm::length(body.account.residual_Ns(source));
    balance.angular_residual_Nms += glm::length(body.account.residual_Nms(source));
  }
  return balance;
}

ImpulseBalance World::joint_balance() const {
  return impl_->BalanceOf(ImpulseSource::kJoint);
}
ImpulseBalance World::contact_balance() const {
  return impl_->BalanceOf(ImpulseSource::kContact);
}

glm::dvec3 World::momentum_Ns(int body) const {
  return impl_->body(body).momentum_Ns();
}
glm::dvec3 World::spin_Nms(int body) const {
  return impl_->body(body).L_W;
}
glm::dvec3 World::center_of_mass_W(int body) const {
  return impl_->body(body).p_WCm;
}
double World::kinetic_energy_J(int body) const {
  return impl_->body(body).kinetic_energy_J();
}

void World::Save(Checkpoint* checkpoint) const {
  checkpoint->BeginWriting();
  impl_->ExchangeState(checkpoint);
}

core::Result<void> World::Restore(Checkpoint* checkpoint) {
  Checkpoint here;
  Save(&here);
  if (here.bytes().size() != checkpoint->bytes().size() ||
      !std::equal(here.bytes().begin(), here.bytes().begin() + 3 * sizeof(std::size_t), checkpoint->bytes().begin())) {
    return core::Fail(
        core::ErrorCode::kInvalidInput,
        "checkpoint: it belongs to another world (bodies, pairs or mechanisms differ); restore it into one "
        "built from the same scenario by the same program");
  }
  checkpoint->BeginReading();
  impl_->ExchangeState(checkpoint);
  for (PairSlot& pair : impl_->pairs) pair.feed.Rest();  // the next step fills it
  return {};
}

std::uint64_t World::num_direct_solves() const {
  return impl_->solver.work().num_direct_solves;
}
std::uint64_t World::num_fallbacks() const {
  return impl_->solver.work().num_fallbacks;
}
const SolverWork& World::solver_work() const {
  return impl_->solver.work();
}

std::uint64_t World::StateHash() const {
  std::uint64_t hash = 0;
  const auto add = [&hash](double number) { hash = core::Hash64(&number, sizeof(number), hash); };
  for (const RigidBody& body : impl_->bodies) {
    const double state[] = {body.p_WCm.x, body.p_WCm.y, body.p_WCm.z, body.R_WB.w,  body.R_WB.x,
                            body.R_WB.y,  body.R_WB.z,  body.v_WCm.x, body.v_WCm.y, body.v_WCm.z,
                            body.L_W.x,   body.L_W.y,   body.L_W.z};
    hash = core::Hash64(state, sizeof(state), hash);
  }
  for (const PairSlot& pair : impl_->pairs) pair.feed.VisitImpulses(add);
  for (const MechanismSlot& slot : impl_->mechanisms) {
    for (const Row& row : slot.mechanism->rows()) add(row.impulse);
    add(slot.mechanism->state());
    add(slot.mechanism->position());
  }
  return hash;
}

}  // namespace physics
