#include "physics/world.hpp"

#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/hash.hpp"
#include "physics/engine/bullet_conversions.hpp"
#include "physics/engine/bullet_world.hpp"
#include "physics/engine/contact_feed.hpp"
#include "physics/engine/rigid_body.hpp"
#include "physics/engine/row_solver.hpp"

namespace physics {
namespace {

constexpr int kMaxBodies = 512;

struct PairSlot {
  int sampled = 0;
  int field = 0;
  ContactFeed feed;
  bool has_wrench = false;
  bool is_muted = false;
  core::Wrench F_So_W;
  ContactReport report;
};

struct MechanismSlot {
  int parent = 0;
  int child = 0;
  std::unique_ptr<Mechanism> mechanism;
  std::unique_ptr<RowConstraint> constraint;
};

}  // namespace

struct World::Impl {
  explicit Impl(const Options& options)
      : dispatcher(&configuration), broadphase(kMaxBodies), world(&dispatcher, &broadphase, &solver, &configuration) {
    world.setGravity(btVector3(0, 0, 0));
    world.set_bodies(&collision_objects);
    btContactSolverInfo& info = world.getSolverInfo();
    info.m_numIterations = options.max_iterations;
    info.m_leastSquaresResidualThreshold = options.tolerance_m_per_s * options.tolerance_m_per_s;
    info.m_splitImpulse = 0;
    info.m_solverMode = SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS;
    info.m_warmstartingFactor = 1.0;
    info.m_damping = 1.0;
  }
  ~Impl() {
    for (MechanismSlot& slot : mechanisms) world.removeConstraint(slot.constraint.get());
    for (RigidBody& body : bodies) world.removeRigidBody(body.engine.get());
  }

  void Apply(ImpulseSource source, RigidBody* body, const glm::dvec3& p_W, const glm::dvec3& impulse_W,
             const glm::dvec3& couple_W) {
    if (body->kind != BodyKind::kDynamic) return;
    body->impulses_Ns += impulse_W;
    const glm::dvec3 angular = glm::cross(p_W, impulse_W) + couple_W;
    body->angular_impulses_Nms += angular;
    body->account.Add(source, impulse_W, angular);
    magnitudes[static_cast<std::size_t>(source)].Ns += glm::length(impulse_W);
    magnitudes[static_cast<std::size_t>(source)].Nms += glm::length(angular);
  }

  void ApplyWrenches(double dt_s) {
    for (PairSlot& pair : pairs) {
      if (!pair.has_wrench || pair.is_muted) continue;
      RigidBody& s = bodies[static_cast<std::size_t>(pair.sampled)];
      RigidBody& g = bodies[static_cast<std::size_t>(pair.field)];
      const glm::dvec3 p_WSo = s.X_WO().translation;
      for (const auto& [body, sign] : {std::pair{&s, 1.0}, std::pair{&g, -1.0}}) {
        if (body->kind != BodyKind::kDynamic) continue;
        const core::Wrench F_Cm =
            core::ShiftWrench(sign * pair.F_So_W, p_WSo - body->p_WCm);  // same point, about this body's Cm
        body->engine->applyCentralForce(ToBullet(F_Cm.force_N));
        body->engine->applyTorque(ToBullet(F_Cm.torque_Nm));
        Apply(ImpulseSource::kOuter, body, p_WSo, dt_s * sign * pair.F_So_W.force_N,
              dt_s * sign * pair.F_So_W.torque_Nm);
      }
      pair.report.F_So_W = pair.F_So_W;
      pair.report.num_pushing = 1;
    }
  }

  void ApplyLoads(double dt_s) {
    for (RigidBody& body : bodies) {
      const core::Wrench& F = body.load_Bo_W;
      if (body.kind != BodyKind::kDynamic || (F.force_N == glm::dvec3(0.0) && F.torque_Nm == glm::dvec3(0.0))) continue;
      const glm::dvec3 p_WBo = body.X_WO().translation;
      const core::Wrench F_Cm = core::ShiftWrench(F, p_WBo - body.p_WCm);
      body.engine->applyCentralForce(ToBullet(F_Cm.force_N));
      body.engine->applyTorque(ToBullet(F_Cm.torque_Nm));
      Apply(ImpulseSource::kOuter, &body, p_WBo, dt_s * F.force_N, dt_s * F.torque_Nm);
    }
  }

  void Collect(double dt_s) {
    for (PairSlot& pair : pairs) {
      RigidBody& s = bodies[static_cast<std::size_t>(pair.sampled)];
      RigidBody& g = bodies[static_cast<std::size_t>(pair.field)];
      const glm::dvec3 p_WSo = s.X_WO().translation;
      pair.feed.Collect([&](const glm::dvec3& p_W, const glm::dvec3& impulse_W) {
        Apply(ImpulseSource::kContact, &s, p_W, impulse_W, glm::dvec3(0.0));
        Apply(ImpulseSource::kContact, &g, p_W, -impulse_W, glm::dvec3(0.0));
        pair.report.F_So_W.force_N += impulse_W / dt_s;
        pair.report.F_So_W.torque_Nm += glm::cross(p_W - p_WSo, impulse_W) / dt_s;
        ++pair.report.num_pushing;
      });
    }
    for (MechanismSlot& slot : mechanisms) {
      RigidBody& child = bodies[static_cast<std::size_t>(slot.child)];
      RigidBody& parent = bodies[static_cast<std::size_t>(slot.parent)];
      for (const Row& row : slot.mechanism->rows()) {
        if (!row.is_active || row.impulse == 0.0) continue;
        Apply(ImpulseSource::kJoint, &child, row.p_W, row.impulse * row.linear_W, row.impulse * row.angular_W);
        Apply(ImpulseSource::kJoint, &parent, row.p_W, -row.impulse * row.linear_W, -row.impulse * row.angular_W);
      }
      slot.mechanism->Finish(dt_s);
    }
  }

  void ExchangeState(Checkpoint* checkpoint) {
    for (std::size_t size : {bodies.size(), pairs.size(), mechanisms.size()}) checkpoint->Exchange(&size);
    for (RigidBody& body : bodies) body.ExchangeState(checkpoint);
    for (PairSlot& pair : pairs) {
      pair.feed.ExchangeState(checkpoint);
      checkpoint->Exchange(&pair.has_wrench);
      checkpoint->Exchange(&pair.is_muted);
      checkpoint->Exchange(&pair.F_So_W);
      checkpoint->Exchange(&pair.report);
    }
    for (MechanismSlot& slot : mechanisms) slot.mechanism->ExchangeState(checkpoint);
    solver.ExchangeState(checkpoint);
    checkpoint->Exchange(&num_steps);
    checkpoint->Exchange(&last_dt_s);
    checkpoint->Exchange(&magnitudes);
  }

  [[nodiscard]] BodyView View(int index) const {
    const RigidBody& b = bodies[static_cast<std::size_t>(index)];
    BodyView view{b.X_WO(), b.V_WO(), b.p_WCm, glm::dvec3(0.0)};
    if (b.kind == BodyKind::kDynamic) view.alpha_W = b.AngularVelocityOf(glm::cross(b.L_W, b.w_W));
    return view;
  }

  [[nodiscard]] ImpulseBalance BalanceOf(ImpulseSource source) const;
  [[nodiscard]] bool has_body(int index) const { return index >= 0 && static_cast<std::size_t>(index) < bodies.size(); }
  RigidBody& body(int index) { return bodies[static_cast<std::size_t>(index)]; }

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher;
  btSimpleBroadphase broadphase;
  RowSolver solver;
  btSphereShape shape{0.01};  // Bullet wants one; nothing ever looks at it
  std::vector<RigidBody> bodies;
  btAlignedObjectArray<btCollisionObject*> collision_objects;
  std::vector<PairSlot> pairs;
  std::vector<MechanismSlot> mechanisms;
  int num_rows = 0;
  std::uint64_t num_steps = 0;
  double last_dt_s = 0.0;
  std::array<ImpulseMagnitude, kNumImpulseSources> magnitudes{};
  BulletWorld world;
};

World::World() : World(Options{}) {}

World::World(const Options& options) : impl_(std::make_unique<Impl>(options)) {
  BodyParams fixed;
  static_cast<void>(AddBody(fixed));  // cannot fail: a fixed body at the origin
}

World::~World() = default;

int World::world_body() const {
  return 0;
}

core::Result<int> World::AddBody(const BodyParams& params) {
  Impl& w = *impl_;
  const std::string name = "body " + std::to_string(w.bodies.size());
  if (w.bodies.size() >= static_cast<std::size_t>(kMaxBodies)) {
    return core::Fail(core::ErrorCode::kResource, name + ": a world holds at most 512 bodies; split the scenario");
  }
  RigidBody body;
  body.kind = params.kind;
  btScalar mass = 0.0;
  btVector3 moments(0, 0, 0);
  if (params.kind == BodyKind::kDynamic) {
    if (!IsPhysical(params.mass)) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        name + ": mass or inertia is not that of a real body (mass " +
                            std::to_string(params.mass.mass_kg) +
                            " kg; moments must be positive and obey the triangle inequality); close the mesh, or give "
                            "another density or mass");
    }
    const PrincipalInertia principal = DiagonalizeInertia(params.mass.I_Cm_O_kg_m2);
    body.mass_kg = params.mass.mass_kg;
    body.moments_kg_m2 = principal.moments_kg_m2;
    body.X_OB = {principal.R_OB, params.mass.p_OCm_m};
    mass = body.mass_kg;
    moments = ToBullet(body.moments_kg_m2);
  }
  body.X_BO = body.X_OB.inverse();
  const core::Pose X_WB = params.X_WO * body.X_OB;
  body.p_WCm = X_WB.translation;
  body.R_WB = X_WB.rotation;
  if (params.kind != BodyKind::kFixed) {
    body.w_W = params.V_WO.angular_rad_per_s;
    body.v_WCm = core::PointVelocity(params.V_WO, params.X_WO.rotate(body.X_OB.translation));
  }
  if (params.kind == BodyKind::kDynamic) body.L_W = body.InertiaTimes(body.w_W);
  body.start_p_Ns = body.momentum_Ns();
  body.start_L_Nms = body.angular_momentum_Nms();

  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &w.shape, moments);
  info.m_linearSleepingThreshold = 0.0;
  info.m_angularSleepingThreshold = 0.0;
  body.engine = std::make_unique<btRigidBody>(info);
  body.engine->setActivationState(DISABLE_DEACTIVATION);
  body.engine->setFlags(0);  // no gyroscopic term: Integrate has it
  body.engine->setDamping(0.0, 0.0);
  if (params.kind == BodyKind::kKinematic) {
    int flags = body.engine->getCollisionFlags() & ~btCollisionObject::CF_STATIC_OBJECT;
    body.engine->setCollisionFlags(flags | btCollisionObject::CF_KINEMATIC_OBJECT);
  }
  body.Push();
  w.world.addRigidBody(body.engine.get(), 0, 0);
  w.collision_objects.push_back(body.engine.get());
  w.bodies.push_back(std::move(body));
  w.solver.Reserve(static_cast<int>(w.bodies.size()), 0, 0);
  return static_cast<int>(w.bodies.size()) - 1;
}

core::Result<int> World::AddContactPair(int sampled_body, int field_body, ContactKind kind) {
  Impl& w = *impl_;
  if (!w.has_body(sampled_body) || !w.has_body(field_body) || sampled_body == field_body) {
    return core::Fail(core::ErrorCode::kInvalidInput, "contact pair: needs two different bodies of this world");
  }
  w.pairs.push_back(PairSlot{sampled_body, field_body,
                             ContactFeed(&w.dispatcher, w.body(sampled_body).engine.get(),
                                         w.body(field_body).engine.get(), kind == ContactKind::kHard),
                             false, false, core::Wrench{}, ContactReport{}});
  w.solver.Reserve(0, static_cast<int>(w.pairs.size() * core::kMaxContactPlanes), 0);
  return static_cast<int>(w.pairs.size()) - 1;
}

core::Result<int> World::AddMechanism(int parent_body, int child_body, std::unique_ptr<Mechanism> mechanism) {
  Impl& w = *impl_;
  if (!w.has_body(parent_body) || !w.has_body(child_body) || parent_body == child_body) {
    return core::Fail(core::ErrorCode::kInvalidInput, "mechanism: needs two different bodies of this world");
  }
  if (w.body(parent_body).kind != BodyKind::kDynamic && w.body(child_body).kind != BodyKind::kDynamic) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "mechanism: neither parent nor child can move; give one of them owner=\"physics\"");
  }
  MechanismSlot slot;
  slot.parent = parent_body;
  slot.child = child_body;
  slot.mechanism = std::move(mechanism);
  slot.constraint =
      std::make_unique<RowConstraint>(*w.body(child_body).engine, *w.body(parent_body).engine, slot.mechanism.get());
  w.num_rows += static_cast<int>(slot.mechanism->rows().size());
  w.world.addConstraint(slot.constraint.get(), true);
  w.mechanisms.push_back(std::move(slot));
  w.solver.Reserve(0, 0, w.num_rows);
  return static_cast<int>(w.mechanisms.size()) - 1;
}

void World::SetKinematic(int index, const core::Pose& X_WO, const core::Twist& V_WO) {
  RigidBody& body = impl_->body(index);
  body.p_WCm = X_WO.translation;  // B = O for a body without mass
  body.R_WB = X_WO.rotation;
  body.v_WCm = V_WO.linear_m_per_s;
  body.w_W = V_WO.angular_rad_per_s;
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
  if (is_muted) slot.feed.Rest();
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
    if (!pair.feed.empty() && !pair.is_muted && !pair.has_wrench) pair.feed.Inject(X_WS, X_WG);
  }
  w.ApplyWrenches(dt_s);
  w.ApplyLoads(dt_s);
  for (MechanismSlot& slot : w.mechanisms) {
    const BodyView parent = w.View(slot.parent);
    const BodyView child = w.View(slot.child);
    slot.mechanism->CarryOnChanges(parent, child, w.num_steps, dt_s);
    slot.mechanism->Prepare(parent, child, dt_s);
  }
  w.world.stepSimulation(dt_s, 0);  // 0: exactly one step; otherwise Bullet keeps its own clock and drops time
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
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "checkpoint: it is of another world (bodies, pairs or mechanisms differ); restore it into one "
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
