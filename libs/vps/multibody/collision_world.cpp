#include "vps/multibody/collision_world.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "core/clock.hpp"
#include "vps/multibody/fast_pair_query.hpp"
#include "vps/multibody/pair_query.hpp"

namespace vps {
namespace {

struct ObjectState {
  std::shared_ptr<const CookedObject> data;
  core::Pose X_WO;
  double reach_m = 0.0;   // radius around the bounding centre that holds the object and its zone of possible hits
  double travel_m = 0.0;  // grows by the largest displacement of any point of that ball at each change of pose
  core::Wrench F_Oo_W;
};

struct PairState {
  PairDescription description;
  PairResult result;
  std::unique_ptr<PairScratch> scratch;           // method paper
  std::unique_ptr<FastPairScratch> fast_scratch;  // method fast
  core::Pose X_GS;                                // of the result
  double free_distance_m = 0.0;                   // of the result; 0: test every cycle
  double distance_at_test_m = 1e9;
  double travel_at_test_m = 0.0;  // sum of both objects' travel
  bool is_valid = false;          // result belongs to the present description
  bool is_fresh = false;
  bool is_late = false;
};

bool IsSame(const core::Pose& a, const core::Pose& b) {
  return a.rotation == b.rotation && a.translation == b.translation;
}

void ClearResult(PairState* pair) {
  pair->result = PairResult{};
  pair->is_valid = false;
}

}  // namespace

struct CollisionWorld::Impl {
  std::vector<ObjectState> objects;
  std::vector<PairState> pairs;
  std::vector<std::uint32_t> due;
  std::vector<std::uint8_t> colliding;  // collision matrix, num_objects squared
  double rho = 0.01;
  double alpha = 2.0;
  Method method = Method::kPaper;
  std::uint64_t cycle = 0;
  StepReport report;
  std::int64_t deadline_ns = 0;  // of the step that runs; 0: none

  void Test(std::size_t order_index) {
    PairState& pair = pairs[due[order_index]];
    // The first always runs, so that even a hopeless budget gets round to every pair.
    if (deadline_ns != 0 && order_index != 0 && core::MonotonicNow_ns() > deadline_ns) {
      pair.is_late = true;
      return;
    }
    const ObjectState& S = objects[pair.description.sampled];
    const ObjectState& G = objects[pair.description.field];
    pair.X_GS = G.X_WO.inverse() * S.X_WO;
    pair.free_distance_m = method == Method::kFast
                               ? QueryFastPair(*S.data->samples, *G.data->field, S.X_WO, pair.X_GS, pair.description,
                                               rho, pair.fast_scratch.get(), &pair.result)
                               : QueryPair(*S.data->points, *G.data->voxmap, S.X_WO, pair.X_GS, pair.description, rho,
                                           alpha, pair.scratch.get(), &pair.result);
    pair.result.cycle = cycle;
    pair.travel_at_test_m = S.travel_m + G.travel_m;
    pair.distance_at_test_m = pair.result.signed_distance_m;
    pair.is_valid = true;
    pair.is_fresh = true;
  }
};

CollisionWorld::CollisionWorld(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CollisionWorld::~CollisionWorld() = default;

core::Result<std::unique_ptr<CollisionWorld>> CollisionWorld::Create(const WorldDescription& description) {
  auto impl = std::make_unique<Impl>();
  impl->rho = description.rho;
  impl->alpha = description.alpha;
  impl->method = description.method;
  for (const ObjectDescription& object : description.objects) {
    ObjectState state;
    state.data = object.data;
    state.X_WO = object.X_WO;
    if (object.data) state.reach_m = object.data->bounding_radius_m;
    impl->objects.push_back(std::move(state));
  }
  for (std::size_t i = 0; i < description.pairs.size(); ++i) {
    const PairDescription& pair = description.pairs[i];
    const std::string name = "collision pair " + std::to_string(i);
    if (pair.sampled >= impl->objects.size() || pair.field >= impl->objects.size() || pair.sampled == pair.field) {
      return core::Fail(core::ErrorCode::kInvalidInput, name + " does not name two different objects");
    }
    const ObjectState& S = impl->objects[pair.sampled];
    ObjectState& G = impl->objects[pair.field];
    if (!S.data || !S.data->has_points(impl->method)) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        name + ": the sampled object has no pointshell; give it points");
    }
    if (!G.data || !G.data->has_field(impl->method)) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        name + ": the field object has no voxelmap; give it a voxel size");
    }
    if (!(pair.look_ahead_m >= 0.0) || !(pair.stiffness_N_per_m >= 0.0)) {
      return core::Fail(core::ErrorCode::kInvalidInput, name + ": look-ahead and stiffness must not be negative");
    }
    // Voxels that count as hits reach beyond G's surface by the look-ahead and the rounding of the layers.
    G.reach_m = std::max(G.reach_m, G.data->bounding_radius_m + pair.look_ahead_m + 4.0 * G.data->voxel_size_m());
    PairState state;
    state.description = pair;
    if (impl->method == Method::kFast) {
      state.fast_scratch = std::make_unique<FastPairScratch>(*S.data->samples);
    } else {
      state.scratch = std::make_unique<PairScratch>(*S.data->points);
    }
    impl->pairs.push_back(std::move(state));
  }
  impl->due.reserve(impl->pairs.size());
  impl->colliding.assign(impl->objects.size() * impl->objects.size(), 0);
  return std::unique_ptr<CollisionWorld>(new CollisionWorld(std::move(impl)));
}

// The largest displacement of any point of a ball of radius r around c when its body turns by angle a and c moves by d
// is at most d + 2 sin(a/2) r; for the turn q the vector part has the length sin(a/2).
void CollisionWorld::SetPose(std::size_t object, const core::Pose& X_WO) {
  ObjectState& state = impl_->objects[object];
  if (IsSame(state.X_WO, X_WO)) return;
  if (state.data) {
    const glm::dvec3 moved = X_WO * state.data->bounding_centre_m - state.X_WO * state.data->bounding_centre_m;
    const glm::dquat turn = X_WO.rotation * glm::conjugate(state.X_WO.rotation);
    const double sine = glm::length(glm::dvec3(turn.x, turn.y, turn.z));
    state.travel_m += (glm::length(moved) + 2.0 * sine * state.reach_m) * (1.0 + 1e-12);
  }
  state.X_WO = X_WO;
}

void CollisionWorld::SetActive(std::size_t pair, bool is_active) {
  PairState& state = impl_->pairs[pair];
  if (state.description.is_active == is_active) return;
  state.description.is_active = is_active;
  ClearResult(&state);
}

void CollisionWorld::SetStiffness(std::size_t pair, double stiffness_N_per_m) {
  impl_->pairs[pair].description.stiffness_N_per_m = stiffness_N_per_m;
  impl_->pairs[pair].is_valid = false;
}

const StepReport& CollisionWorld::Step(core::ParallelFor* workers, std::int64_t budget_ns) {
  Impl& w = *impl_;
  ++w.cycle;
  w.deadline_ns = budget_ns > 0 ? core::MonotonicNow_ns() + budget_ns : 0;
  w.report = {};
  w.due.clear();
  for (std::size_t i = 0; i < w.pairs.size(); ++i) {
    PairState& pair = w.pairs[i];
    pair.is_fresh = false;
    pair.is_late = false;
    ++w.report.pairs_considered;
    if (!pair.description.is_active) {
      ++w.report.pairs_inactive;
      continue;
    }
    const ObjectState& S = w.objects[pair.description.sampled];
    const ObjectState& G = w.objects[pair.description.field];
    if (pair.is_valid && pair.free_distance_m > 0.0) {
      const double moved_m = S.travel_m + G.travel_m - pair.travel_at_test_m;
      if (moved_m < pair.free_distance_m) {
        pair.result.signed_distance_m = pair.distance_at_test_m - moved_m;
        ++w.report.pairs_coherent;
        continue;
      }
    } else if (pair.is_valid && IsSame(pair.X_GS, G.X_WO.inverse() * S.X_WO)) {
      pair.result.F_So_W = PenaltyWrench(pair.description.stiffness_N_per_m, Rotate(S.X_WO, pair.result.f_So_S));
      pair.result.cycle = w.cycle;
      pair.is_fresh = true;
      ++w.report.pairs_unchanged;
      continue;
    }
    w.due.push_back(static_cast<std::uint32_t>(i));
  }
  if (w.deadline_ns != 0) {  // oldest result first [VR-OOS, section 3]; without a budget the order changes nothing
    std::sort(w.due.begin(), w.due.end(), [&](std::uint32_t a, std::uint32_t b) {
      const std::uint64_t age_a = w.pairs[a].result.cycle;
      const std::uint64_t age_b = w.pairs[b].result.cycle;
      return age_a != age_b ? age_a < age_b : a < b;
    });
  }
  workers->Run(
      w.due.size(), [](void* impl, std::size_t i) { static_cast<Impl*>(impl)->Test(i); }, &w);

  // Everything that is summed is summed here, in pair order, whoever computed it.
  for (ObjectState& object : w.objects) object.F_Oo_W = {};
  std::fill(w.colliding.begin(), w.colliding.end(), std::uint8_t{0});
  for (const std::uint32_t i : w.due) {
    PairState& pair = w.pairs[i];
    if (pair.is_late) {
      ++w.report.pairs_late;
      w.report.oldest_result_cycles =
          std::max(w.report.oldest_result_cycles, static_cast<std::uint32_t>(w.cycle - pair.result.cycle));
      continue;
    }
    ++w.report.pairs_tested;
    w.report.counters.spheres_tested += pair.result.counters.spheres_tested;
    w.report.counters.points_tested += pair.result.counters.points_tested;
    w.report.counters.points_colliding += pair.result.counters.points_colliding;
  }
  for (const PairState& pair : w.pairs) {
    if (!pair.description.is_active || !pair.result.is_in_contact) continue;
    ++w.report.pairs_in_contact;
    const std::size_t s = pair.description.sampled;
    const std::size_t g = pair.description.field;
    w.colliding[s * w.objects.size() + g] = w.colliding[g * w.objects.size() + s] = 1;
    w.objects[s].F_Oo_W += pair.result.F_So_W;
    const glm::dvec3 p_GS_W = w.objects[s].X_WO.translation - w.objects[g].X_WO.translation;
    w.objects[g].F_Oo_W += -core::ShiftWrench(pair.result.F_So_W, p_GS_W);
  }
  return w.report;
}

void CollisionWorld::HandContact(const std::vector<std::uint8_t>& is_hand_part, const core::Pose& X_WC,
                                 CouplingContact* contact, int ignored_object) const {
  const Impl& w = *impl_;
  *contact = {};
  for (const PairState& pair : w.pairs) {
    const std::size_t s = pair.description.sampled;
    const std::size_t g = pair.description.field;
    if (!pair.description.is_active || (is_hand_part[s] != 0) == (is_hand_part[g] != 0)) continue;
    if (ignored_object >= 0 && (s == std::size_t(ignored_object) || g == std::size_t(ignored_object))) continue;
    const PairResult& result = pair.result;
    contact->free_distance_m =
        std::min(contact->free_distance_m,
                 result.planes.empty() ? std::max(0.0, result.signed_distance_m) : pair.description.look_ahead_m);
    if (result.planes.empty()) continue;
    // Everything below is what the hand feels: of the sampled side as it is, of the field side the opposite.
    const double side = is_hand_part[s] != 0 ? 1.0 : -1.0;
    const core::Pose& X_WS = w.objects[s].X_WO;
    const core::Pose& X_WG = w.objects[g].X_WO;
    if (result.is_in_contact) {
      contact->is_in_contact = true;
      contact->deepest_penetration_m = std::max(contact->deepest_penetration_m, -result.signed_distance_m);
      contact->f_Co_W += side * Shift(Rotate(X_WS, result.f_So_S), X_WS.translation - X_WC.translation);
    }
    for (const core::ContactPlane& plane : result.planes) {
      CouplingPlane row;
      const glm::dvec3 p_W = X_WS * glm::dvec3(plane.p_S);
      const glm::dvec3 n_W = X_WG.rotate(glm::dvec3(plane.n_G));
      row.gap_m = glm::dot(n_W, p_W - X_WG * glm::dvec3(plane.q_G));
      row.p_CoQ_W = p_W - X_WC.translation;
      row.n_W = side * n_W;
      // When the hand has more planes than fit, those that are farthest from touching give way.
      if (contact->planes.push_back(row)) continue;
      auto* loosest = std::max_element(contact->planes.begin(), contact->planes.end(),
                                       [](const auto& a, const auto& b) { return a.gap_m < b.gap_m; });
      if (row.gap_m < loosest->gap_m) *loosest = row;
    }
  }
}

void CollisionWorld::FillContactSet(std::size_t pair_index, core::ContactSet* message) const {
  const PairState& pair = impl_->pairs[pair_index];
  message->pair_index = static_cast<std::uint16_t>(pair_index);
  message->sampled_body = pair.description.sampled;
  message->field_body = pair.description.field;
  message->cycle = pair.result.cycle;
  message->signed_distance_m = pair.result.signed_distance_m;
  message->is_in_contact = pair.result.is_in_contact;
  message->F_So_W = pair.result.F_So_W;
  message->damping_N_s_per_m = static_cast<float>(pair.description.damping_N_s_per_m);
  message->friction = static_cast<float>(pair.description.friction);
  message->planes = pair.result.planes;
}

double CollisionWorld::RestPenetration(const std::vector<std::uint8_t>& is_hand_part) const {
  double coarsest_m = 0.0;
  for (const PairState& pair : impl_->pairs) {
    if ((is_hand_part[pair.description.sampled] != 0) == (is_hand_part[pair.description.field] != 0)) continue;
    coarsest_m = std::max(coarsest_m, impl_->objects[pair.description.field].data->voxel_size_m());
  }
  return coarsest_m > 0.0 ? 0.5 * coarsest_m : 2.5e-4;
}

std::size_t CollisionWorld::num_objects() const {
  return impl_->objects.size();
}
std::size_t CollisionWorld::num_pairs() const {
  return impl_->pairs.size();
}
const PairDescription& CollisionWorld::pair(std::size_t pair) const {
  return impl_->pairs[pair].description;
}
const PairResult& CollisionWorld::result(std::size_t pair) const {
  return impl_->pairs[pair].result;
}
bool CollisionWorld::is_active(std::size_t pair) const {
  return impl_->pairs[pair].description.is_active;
}
bool CollisionWorld::is_fresh(std::size_t pair) const {
  return impl_->pairs[pair].is_fresh;
}
bool CollisionWorld::AreColliding(std::size_t object_a, std::size_t object_b) const {
  return impl_->colliding[object_a * impl_->objects.size() + object_b] != 0;
}
const core::Wrench& CollisionWorld::ObjectWrench(std::size_t object) const {
  return impl_->objects[object].F_Oo_W;
}

}  // namespace vps
