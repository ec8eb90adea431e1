#include "vps/multibody/collision_world.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <map>
#include <numeric>
#include <string>

#include "core/clock.hpp"
#include "vps/multibody/fast_pair_query.hpp"
#include "vps/multibody/gap_query.hpp"
#include "vps/multibody/pair_query.hpp"
#include "vps/multibody/pair_schedule.hpp"
#include "vps/walk/walk_memory.hpp"

namespace vps {
namespace {

// Pairs tested at the same time; the memory of each is sized for the largest object. Not derived: bounds memory.
constexpr std::size_t kMaxPairsAtOnce = 32;

struct PairEntry : PairMemory {  // but for the state, which is one of Impl's phases
  PairDescription description;
  bool is_late = false;
  FieldWalkMemory walk_memory;
  std::uint32_t points_due = 0;   // that its last query would have tested without a budget
  std::uint32_t most_points = 0;  // its share of this step's budget; 0: no limit
  // Of a pair with gaps; else null.
  const TouchPoints* touch_points = nullptr;
  std::unique_ptr<GapPlanes> gaps;

  // That is walked, of `fast`.
  [[nodiscard]] const SampleTree& TreeOf(const CookedObject& S) const {
    return touch_points != nullptr ? touch_points->tree : S.SamplesAt(touch.coarseness);
  }
  [[nodiscard]] std::span<const core::ContactPlane> planes() const {
    if (gaps != nullptr) return {gaps->planes.begin(), gaps->planes.size()};
    return {result.planes.begin(), result.planes.size()};
  }
  void ClearResult() {
    result = PairResult{};
    if (gaps != nullptr) gaps->Clear();
    is_current = false;
  }
};

bool IsSame(const core::Pose& a, const core::Pose& b) {
  return a.rotation == b.rotation && a.translation == b.translation;
}

// Where there are more planes than fit, those that are farthest from touching give way.
template <class Plane, std::size_t kMost>
void PutNearest(const Plane& plane, core::FixedVector<Plane, kMost>* planes) {
  if (planes->push_back(plane)) return;
  Plane* const loosest = std::max_element(planes->begin(), planes->end(),
                                          [](const Plane& a, const Plane& b) { return a.gap_m < b.gap_m; });
  if (plane.gap_m < loosest->gap_m) *loosest = plane;
}

double DeepestPlane_m(const PairResult& result, const core::Pose& X_WS, const core::Pose& X_WG) {
  double deepest_m = -std::numeric_limits<double>::infinity();
  for (const core::ContactPlane& plane : result.planes) {
    const glm::dvec3 p_WQ = X_WG * glm::dvec3(plane.q_G);
    deepest_m = std::max(deepest_m, -glm::dot(X_WG.rotate(glm::dvec3(plane.n_G)), X_WS * glm::dvec3(plane.p_S) - p_WQ));
  }
  return deepest_m;
}

}  // namespace

struct CollisionWorld::Impl {
  std::vector<std::shared_ptr<const CookedObject>> objects;
  std::vector<core::Wrench> F_Oo_W;                                    // per object
  std::map<std::uint16_t, std::unique_ptr<TouchPoints>> touch_points;  // of objects sampled by pairs with gaps
  std::vector<PairEntry> pairs;
  std::vector<PairState> phases;  // per pair, never kAsleep; apart from the entries, because all are gone through
  PairSchedule schedule;
  PairBits touching;
  std::vector<std::uint32_t> due;
  std::vector<PairScratch> scratch;           // method paper
  std::vector<FastPairScratch> fast_scratch;  // method fast
  double rho = 0.01;
  double alpha = 2.0;
  Method method = Method::kPaper;
  std::uint64_t cycle = 0;
  std::uint32_t num_inactive = 0;
  std::uint32_t num_touching = 0;
  StepReport report;
  double delay_cycles = -2.0;    // until SetDelay: nothing is covered
  std::int64_t deadline_ns = 0;  // of the step that runs; 0: none
  std::size_t first_due = 0;     // of those that are tested at the same time; the one after has slot 1, and so on
  // Of `fast`, per slot.
  enum class Fate : std::uint8_t { kOpen, kRuns, kLate };
  std::array<std::uint32_t, kMaxPairsAtOnce> num_chunks{};
  std::array<std::atomic<Fate>, kMaxPairsAtOnce> fates{};

  core::Result<void> AddPair(const PairDescription& pair);
  void MakeScratch();
  void SetPhase(std::size_t i, PairState phase);
  void SetApart(std::size_t i, double free_m);
  void Sort(std::size_t i);
  [[nodiscard]] bool IsTimeUp(std::size_t slot) const;
  [[nodiscard]] double LookAhead_m(const PairDescription& pair) const;
  void TestPaper(std::size_t slot);
  void PrepareFast(std::size_t slot);
  void EvaluateFast(std::size_t index);
  void FinishFast(std::size_t slot);
  void ShareOut(std::uint64_t budget_points);
  void TestSome(core::ParallelFor* workers);
  void Settle(std::size_t i);
  void Take(std::size_t i);
  void Sum();
  template <class Visit>
  void ForHandPairs(const std::vector<std::uint8_t>& is_hand_part, int ignored_object,
                    std::span<const core::Pose> moved_X_WO, const Visit& visit) const;
};

CollisionWorld::CollisionWorld(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
CollisionWorld::~CollisionWorld() = default;

core::Result<std::unique_ptr<CollisionWorld>> CollisionWorld::Create(const WorldDescription& description) {
  auto impl = std::make_unique<Impl>();
  impl->rho = description.rho;
  impl->alpha = description.alpha;
  impl->method = description.method;
  for (const ObjectDescription& object : description.objects) {
    impl->objects.push_back(object.data);
    const bool is_solid = object.data != nullptr;
    impl->schedule.AddObject(object.X_WO, is_solid ? object.data->bounding_centre_m : glm::dvec3(0.0),
                             is_solid ? object.data->bounding_radius_m : 0.0);
  }
  impl->F_Oo_W.resize(description.objects.size());
  for (const PairDescription& pair : description.pairs) {
    if (const auto added = impl->AddPair(pair); !added) return core::Fail(added.error().code, added.error().detail);
  }
  impl->schedule.Finish();
  for (std::size_t i = 0; i < impl->pairs.size(); ++i) {
    if (!impl->pairs[i].description.is_active) impl->schedule.Stop(i);
  }
  impl->touching = PairBits(impl->pairs.size());
  impl->due.reserve(impl->pairs.size());
  impl->MakeScratch();
  return std::unique_ptr<CollisionWorld>(new CollisionWorld(std::move(impl)));
}

core::Result<void> CollisionWorld::Impl::AddPair(const PairDescription& pair) {
  const std::string name = "collision pair " + std::to_string(pairs.size());
  if (pair.sampled >= objects.size() || pair.field >= objects.size() || pair.sampled == pair.field) {
    return core::Fail(core::ErrorCode::kInvalidInput, name + " does not name two different objects");
  }
  const CookedObject* const S = objects[pair.sampled].get();
  const CookedObject* const G = objects[pair.field].get();
  if (S == nullptr || !S->has_points(method)) {
    return core::Fail(core::ErrorCode::kInvalidInput, name + ": the sampled object has no pointshell; give it points");
  }
  if (G == nullptr || !G->has_field(method)) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      name + ": the field object has no voxelmap; give it a voxel size");
  }
  if (pairs.size() > PairOfHandPlane(~0U)) {
    return core::Fail(core::ErrorCode::kInvalidInput, name + ": more pairs than ids of planes can name");
  }
  if (!(pair.look_ahead_m >= 0.0) || !(pair.stiffness_N_per_m >= 0.0)) {
    return core::Fail(core::ErrorCode::kInvalidInput, name + ": look-ahead and stiffness must not be negative");
  }
  // Voxels that count as hits reach beyond G's surface by the look-ahead and the rounding of the layers.
  schedule.AddPair(pair.sampled, pair.field, pair.look_ahead_m + 4.0 * G->voxel_size_m());
  PairEntry entry;
  entry.description = pair;
  if (pair.has_gaps && method == Method::kFast) {
    std::unique_ptr<TouchPoints>& touch = touch_points[pair.sampled];
    if (touch == nullptr) touch = std::make_unique<TouchPoints>(FindTouchPoints(*S->samples, *S->surface));
    entry.touch_points = touch.get();
    entry.gaps = std::make_unique<GapPlanes>();
  }
  pairs.push_back(std::move(entry));
  phases.push_back(pair.is_active ? PairState::kFar : PairState::kInactive);
  num_inactive += pair.is_active ? 0 : 1;
  return {};
}

// Every piece of scratch serves every pair, so it has room for the largest sampled object.
void CollisionWorld::Impl::MakeScratch() {
  const std::size_t count = std::min(kMaxPairsAtOnce, pairs.size());
  const SampleTree* largest = nullptr;
  std::size_t most_places = 0;
  for (const PairEntry& pair : pairs) {
    const CookedObject& S = *objects[pair.description.sampled];
    if (method == Method::kFast) {
      const SampleTree& tree = pair.TreeOf(S);
      most_places = std::max<std::size_t>(most_places, pair.description.most_places);
      if (largest == nullptr || tree.points.size() > largest->points.size()) largest = &tree;
      continue;
    }
    while (scratch.size() < count) scratch.emplace_back(*S.points);
    for (PairScratch& one : scratch) one.query.MakeRoomFor(*S.points);
  }
  while (largest != nullptr && fast_scratch.size() < count) {
    fast_scratch.emplace_back(*largest);
    fast_scratch.back().surface.Reserve(most_places);
    if (!touch_points.empty()) fast_scratch.back().gaps = std::make_unique<GapScratch>();
  }
}

void CollisionWorld::SetPose(std::size_t object, const core::Pose& X_WO) {
  impl_->schedule.SetPose(object, X_WO);
}

void CollisionWorld::SetActive(std::size_t i, bool is_active) {
  Impl& w = *impl_;
  PairEntry& pair = w.pairs[i];
  if (pair.description.is_active == is_active) return;
  pair.description.is_active = is_active;
  pair.ClearResult();
  pair.touch = {};
  w.SetPhase(i, is_active ? PairState::kFar : PairState::kInactive);
  w.num_inactive += is_active ? -1U : 1U;
  if (is_active) {
    w.schedule.Wake(i);
  } else {
    w.schedule.Stop(i);
  }
}

void CollisionWorld::SetDelay(double delay_cycles) {
  impl_->delay_cycles = delay_cycles;
}

void CollisionWorld::SetStiffness(std::size_t i, double stiffness_N_per_m) {
  PairEntry& pair = impl_->pairs[i];
  pair.description.stiffness_N_per_m = stiffness_N_per_m;
  pair.is_current = false;
  pair.touch.apart_m = 0.0;  // what is negligible depends on the stiffness
  if (pair.description.is_active) impl_->schedule.Wake(i);
}

PairMemory CollisionWorld::Memory(std::size_t i) const {
  PairMemory memory = static_cast<const PairMemory&>(impl_->pairs[i]);
  memory.state = impl_->phases[i];
  memory.free_m = std::max(0.0, impl_->schedule.FreeDistance_m(i));
  return memory;
}

void CollisionWorld::Continue(std::size_t i, const PairMemory& memory) {
  PairEntry& pair = impl_->pairs[i];
  if (!pair.description.is_active || memory.state == PairState::kInactive) return;
  static_cast<PairMemory&>(pair) = memory;
  pair.result.cycle = impl_->cycle;
  impl_->SetPhase(i, memory.state);
  impl_->Settle(i);
}

const core::Pose& CollisionWorld::X_WO(std::size_t object) const {
  return impl_->schedule.X_WO(object);
}

void CollisionWorld::Impl::SetPhase(std::size_t i, PairState phase) {
  if ((phases[i] == PairState::kContact) != (phase == PairState::kContact)) {
    if (phase == PairState::kContact) {
      touching.Set(i);
      ++num_touching;
    } else {
      touching.Clear(i);
      --num_touching;
    }
  }
  phases[i] = phase;
}

// Far pairs' entries are not touched again: what they had was cleared when they went far.
void CollisionWorld::Impl::SetApart(std::size_t i, double free_m) {
  if (phases[i] != PairState::kFar) {
    pairs[i].ClearResult();
    pairs[i].touch.coarseness = 0;  // a contact starts with all samples
    SetPhase(i, PairState::kFar);
  }
  schedule.Rest(i, free_m);
  ++report.pairs_bounded;
}

// Classifies a selected pair: its result still holds at this pose; its bounding spheres are apart; or its trees have to
// be tested.
void CollisionWorld::Impl::Sort(std::size_t i) {
  PairEntry& pair = pairs[i];
  pair.is_late = false;
  const bool is_asleep = pair.is_current && !schedule.HasMoved(i);
  if (!is_asleep) {
    const double longer_m = LookAhead_m(pair.description) - pair.description.look_ahead_m;  // than the ball's zone
    if (const double gap_m = schedule.BallGap(i) - longer_m; gap_m > 0.0) {
      SetApart(i, gap_m);
      return;
    }
    const core::Pose& X_WS = schedule.X_WO(pair.description.sampled);
    if (!pair.is_current || !IsSame(pair.X_GS, schedule.X_WO(pair.description.field).inverse() * X_WS)) {
      due.push_back(static_cast<std::uint32_t>(i));
      return;
    }
    pair.result.F_So_W = PenaltyWrench(pair.description.stiffness_N_per_m, Rotate(X_WS, pair.result.f_So_S));
    Settle(i);
  }
  pair.result.cycle = cycle;
  ++report.pairs_unchanged;
}

// The first always runs, so that even a hopeless budget gets round to every pair.
bool CollisionWorld::Impl::IsTimeUp(std::size_t slot) const {
  return deadline_ns != 0 && first_due + slot != 0 && core::MonotonicNow_ns() > deadline_ns;
}

double CollisionWorld::Impl::LookAhead_m(const PairDescription& pair) const {
  if (method != Method::kPaper) return pair.look_ahead_m;  // the field of `fast` is exact only up to two voxels outside
  const double covered_m = (schedule.Pace_m(pair.sampled) + schedule.Pace_m(pair.field)) * (delay_cycles + 2.0);
  // In steps, so that the planes, which depend on it, do not change in every cycle.
  return pair.look_ahead_m * (covered_m <= pair.look_ahead_m ? 1.0 : covered_m <= 2.0 * pair.look_ahead_m ? 2.0 : 4.0);
}

void CollisionWorld::Impl::TestPaper(std::size_t slot) {
  PairEntry& pair = pairs[due[first_due + slot]];
  pair.is_late = IsTimeUp(slot);
  if (pair.is_late) return;
  PairDescription d = pair.description;
  d.look_ahead_m = LookAhead_m(d);
  const core::Pose& X_WS = schedule.X_WO(d.sampled);
  pair.X_GS = schedule.X_WO(d.field).inverse() * X_WS;
  pair.free_m = QueryPair(*objects[d.sampled]->points, *objects[d.field]->voxmap, X_WS, pair.X_GS, d, rho, alpha,
                          &scratch[slot], &pair.result);
  pair.result.cycle = cycle;
}

void CollisionWorld::Impl::PrepareFast(std::size_t slot) {
  PairEntry& pair = pairs[due[first_due + slot]];
  num_chunks[slot] = 0;
  fates[slot].store(IsTimeUp(slot) ? Fate::kLate : Fate::kOpen, std::memory_order_relaxed);
  if (fates[slot].load(std::memory_order_relaxed) == Fate::kLate) return;
  const PairDescription& d = pair.description;
  pair.X_GS = schedule.X_WO(d.field).inverse() * schedule.X_WO(d.sampled);
  fast_scratch[slot].walk.memory = &pair.walk_memory;
  fast_scratch[slot].walk.most_points = pair.most_points;
  const SampleTree& sampled = pair.TreeOf(*objects[d.sampled]);
  num_chunks[slot] = fast_scratch[slot].walk.Prepare(sampled, *objects[d.field]->field, pair.X_GS,
                                                     WalkMargin_m(sampled, d.look_ahead_m));
}

// The first worker at a pair's chunks decides for all of them whether there is time.
void CollisionWorld::Impl::EvaluateFast(std::size_t index) {
  std::size_t slot = 0;
  for (; index >= num_chunks[slot]; ++slot) index -= num_chunks[slot];
  if (deadline_ns != 0) {
    Fate fate = fates[slot].load(std::memory_order_relaxed);
    if (fate == Fate::kOpen) {
      const Fate mine = IsTimeUp(slot) ? Fate::kLate : Fate::kRuns;
      if (fates[slot].compare_exchange_strong(fate, mine, std::memory_order_relaxed)) fate = mine;
    }
    if (fate == Fate::kLate) return;
  }
  fast_scratch[slot].walk.Evaluate(static_cast<std::uint32_t>(index));
}

void CollisionWorld::Impl::FinishFast(std::size_t slot) {
  PairEntry& pair = pairs[due[first_due + slot]];
  pair.is_late = fates[slot].load(std::memory_order_relaxed) == Fate::kLate;
  if (pair.is_late) return;
  const PairDescription& d = pair.description;
  const CookedObject& S = *objects[d.sampled];
  const CookedObject& G = *objects[d.field];
  const FastPair parts =
      pair.gaps != nullptr ? FastPair{pair.TreeOf(S), *S.surface, *G.field, *G.bends} : FastPairOf(S, G, pair.touch);
  const core::Pose& X_WS = schedule.X_WO(d.sampled);
  FastPairScratch* const memory = &fast_scratch[slot];
  memory->found = memory->walk.Finish();
  memory->memory = &pair.touch;
  memory->most_points = pair.most_points;
  if (pair.gaps != nullptr) {
    pair.free_m =
        FinishGapPair(parts, *pair.touch_points, X_WS, pair.X_GS, d, rho, memory, pair.gaps.get(), &pair.result);
  } else {
    pair.free_m = FinishFastPair(parts, X_WS, pair.X_GS, d, rho, memory, &pair.result);
  }
  pair.result.cycle = cycle;
  pair.result.is_cut_short = memory->is_cut_short;
  pair.points_due = memory->points_due;
}

// Distributes the budget in proportion to the points that each pair's last query had to test; at least kSmall are
// assumed, and for pairs that have not been tested yet. Not derived.
void CollisionWorld::Impl::ShareOut(std::uint64_t budget_points) {
  constexpr std::uint32_t kSmall = 1024;
  constexpr std::uint64_t kMost = 0xffffffffU;
  const auto wanted_by = [&](std::uint32_t i) { return std::uint64_t{std::max(pairs[i].points_due, kSmall)}; };
  std::uint64_t wanted = 0;
  for (const std::uint32_t i : due) wanted += wanted_by(i);
  for (const std::uint32_t i : due) {
    const std::uint64_t all = wanted > budget_points ? wanted : wanted_by(i);
    const std::uint64_t share = std::clamp<std::uint64_t>(budget_points * wanted_by(i) / all, 1, kMost);
    pairs[i].most_points = budget_points == 0 ? 0 : static_cast<std::uint32_t>(share);
  }
}

// The pairs from `first_due` on, as many as there is scratch for. `fast` spreads the chunks of all their walks over the
// workers, so that one heavy pair does not keep the others waiting.
void CollisionWorld::Impl::TestSome(core::ParallelFor* workers) {
  const std::size_t count = std::min(kMaxPairsAtOnce, due.size() - first_due);
  const auto run = [&]<auto Part>(std::size_t n) {
    workers->Run(
        n, [](void* impl, std::size_t i) { (static_cast<Impl*>(impl)->*Part)(i); }, this);
  };
  if (method == Method::kPaper) {
    run.template operator()<&Impl::TestPaper>(count);
    return;
  }
  run.template operator()<&Impl::PrepareFast>(count);
  run.template operator()<&Impl::EvaluateFast>(
      std::accumulate(num_chunks.begin(), num_chunks.begin() + count, std::size_t{0}));
  run.template operator()<&Impl::FinishFast>(count);
}

// A result of this pose: when the next one is needed.
void CollisionWorld::Impl::Settle(std::size_t i) {
  if (pairs[i].free_m > 0.0) {
    schedule.Rest(i, pairs[i].free_m);
  } else {
    schedule.Hold(i);
  }
}

// Enters the result of a test into the schedule and the report.
void CollisionWorld::Impl::Take(std::size_t i) {
  PairEntry& pair = pairs[i];
  if (pair.is_late) {
    pair.is_current = false;
    schedule.Wake(i);
    ++report.pairs_late;
    const std::uint64_t age = pair.result.cycle == 0 ? 0 : cycle - pair.result.cycle;
    report.oldest_result_cycles = std::max(report.oldest_result_cycles, static_cast<std::uint32_t>(age));
    return;
  }
  pair.is_current = true;
  SetPhase(i, pair.result.is_in_contact ? PairState::kContact : PairState::kNear);
  Settle(i);
  ++report.pairs_tested;
  report.pairs_cut_short += pair.result.is_cut_short ? 1 : 0;
  report.counters.spheres_tested += pair.result.counters.spheres_tested;
  report.counters.points_tested += pair.result.counters.points_tested;
  report.counters.points_colliding += pair.result.counters.points_colliding;
}

// In pair order, so that the bits do not depend on the workers.
void CollisionWorld::Impl::Sum() {
  std::fill(F_Oo_W.begin(), F_Oo_W.end(), core::Wrench{});
  touching.ForEach([this](std::size_t i) {
    const std::size_t s = schedule.a(i);
    const std::size_t g = schedule.b(i);
    const core::Wrench& F_So_W = pairs[i].result.F_So_W;
    F_Oo_W[s] += F_So_W;
    F_Oo_W[g] += -core::ShiftWrench(F_So_W, schedule.X_WO(s).translation - schedule.X_WO(g).translation);
  });
}

const StepReport& CollisionWorld::Step(core::ParallelFor* workers, std::int64_t budget_ns,
                                       std::uint64_t budget_points) {
  Impl& w = *impl_;
  ++w.cycle;
  w.deadline_ns = budget_ns > 0 ? core::MonotonicNow_ns() + budget_ns : 0;
  w.report = {};
  w.due.clear();
  const std::vector<std::uint32_t>& selected = w.schedule.Collect();
  for (const std::uint32_t i : selected) w.Sort(i);
  w.report.pairs_considered = static_cast<std::uint32_t>(w.pairs.size());
  w.report.pairs_inactive = w.num_inactive;
  w.report.pairs_coherent = w.report.pairs_considered - w.num_inactive - static_cast<std::uint32_t>(selected.size());
  if (w.deadline_ns != 0) {  // oldest result first [VR-OOS, section 3]; without a budget the order changes nothing
    std::sort(w.due.begin(), w.due.end(), [&](std::uint32_t a, std::uint32_t b) {
      const std::uint64_t age_a = w.pairs[a].result.cycle;
      const std::uint64_t age_b = w.pairs[b].result.cycle;
      return age_a != age_b ? age_a < age_b : a < b;
    });
  }
  w.ShareOut(budget_points);
  for (w.first_due = 0; w.first_due < w.due.size(); w.first_due += kMaxPairsAtOnce) w.TestSome(workers);
  for (const std::uint32_t i : w.due) w.Take(i);
  w.report.pairs_in_contact = w.num_touching;
  w.Sum();
  return w.report;
}

double CollisionWorld::Depth_m(std::size_t i, std::span<const core::Pose> moved_X_WO) const {
  const Impl& w = *impl_;
  const PairResult& result = w.pairs[i].result;
  if (moved_X_WO.empty() || result.planes.empty()) return -result.signed_distance_m;
  const std::size_t s = w.schedule.a(i);
  const std::size_t g = w.schedule.b(i);
  return -result.signed_distance_m + DeepestPlane_m(result, moved_X_WO[s], moved_X_WO[g]) -
         DeepestPlane_m(result, w.schedule.X_WO(s), w.schedule.X_WO(g));
}

// visit(pair, X_WS, X_WG): the active pairs of which exactly one side is of the hand, but for those of
// `ignored_object`.
template <class Visit>
void CollisionWorld::Impl::ForHandPairs(const std::vector<std::uint8_t>& is_hand_part, int ignored_object,
                                        std::span<const core::Pose> moved_X_WO, const Visit& visit) const {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::size_t s = schedule.a(i);
    const std::size_t g = schedule.b(i);
    if (phases[i] == PairState::kInactive || (is_hand_part[s] != 0) == (is_hand_part[g] != 0)) continue;
    if (ignored_object >= 0 && (s == std::size_t(ignored_object) || g == std::size_t(ignored_object))) continue;
    visit(i, moved_X_WO.empty() ? schedule.X_WO(s) : moved_X_WO[s],
          moved_X_WO.empty() ? schedule.X_WO(g) : moved_X_WO[g]);
  }
}

void CollisionWorld::HandContact(const std::vector<std::uint8_t>& is_hand_part, const core::Pose& X_WC,
                                 CouplingContact* contact, int ignored_object,
                                 std::span<const core::Pose> moved_X_WO) const {
  *contact = {};
  impl_->ForHandPairs(
      is_hand_part, ignored_object, moved_X_WO, [&](std::size_t i, const core::Pose& X_WS, const core::Pose& X_WG) {
        const PairEntry& pair = impl_->pairs[i];
        const PairResult& result = pair.result;
        const double rest_m = RestPenetration_m(i);
        contact->free_distance_m = std::min(contact->free_distance_m, ApartAtLeast_m(i) + rest_m);
        if (result.planes.empty()) return;
        // The wrench on the hand: as it is if the hand is the sampled side, its opposite if it is the field.
        const double side = is_hand_part[pair.description.sampled] != 0 ? 1.0 : -1.0;
        const double depth_m = Depth_m(i, moved_X_WO);
        if (result.is_in_contact && (moved_X_WO.empty() || depth_m >= 0.0)) {
          contact->is_in_contact = true;
          contact->deepest_excess_m = std::max(contact->deepest_excess_m, depth_m - rest_m);
          contact->f_Co_W += side * Shift(Rotate(X_WS, result.f_So_S), X_WS.translation - X_WC.translation);
        }
        for (const core::ContactPlane& plane : result.planes) {
          CouplingPlane row;
          const glm::dvec3 p_W = X_WS * glm::dvec3(plane.p_S);
          const glm::dvec3 n_W = X_WG.rotate(glm::dvec3(plane.n_G));
          row.gap_m = glm::dot(n_W, p_W - X_WG * glm::dvec3(plane.q_G));
          row.p_CoQ_W = p_W - X_WC.translation;
          row.n_W = side * n_W;
          row.rest_m = rest_m;
          PutNearest(row, &contact->planes);
        }
      });
}

std::uint32_t CollisionWorld::HandPlaneId(std::size_t pair, const core::ContactPlane& plane) {
  return (static_cast<std::uint32_t>(pair) << 16U) | plane.id;
}

void CollisionWorld::KeepHandPlane(std::uint32_t id) {
  GapPlanes* const gaps = impl_->pairs[PairOfHandPlane(id)].gaps.get();
  if (gaps != nullptr) gaps->Keep(id & 0xffffU);
}

void CollisionWorld::HandPlanes(const std::vector<std::uint8_t>& is_hand_part, ToolContact* contact, int ignored_object,
                                std::span<const core::Pose> moved_X_WO) const {
  *contact = {};
  impl_->ForHandPairs(is_hand_part, ignored_object, moved_X_WO,
                      [&](std::size_t i, const core::Pose& X_WS, const core::Pose& X_WG) {
                        const PairEntry& pair = impl_->pairs[i];
                        const PairDescription& d = pair.description;
                        contact->free_distance_m = std::min(contact->free_distance_m, ApartAtLeast_m(i));
                        const bool is_hand_sampled = is_hand_part[d.sampled] != 0;
                        for (const core::ContactPlane& from : pair.planes()) {
                          const glm::dvec3 p_W = X_WS * glm::dvec3(from.p_S);
                          const glm::dvec3 n_W = X_WG.rotate(glm::dvec3(from.n_G));
                          ToolPlane plane;
                          plane.id = HandPlaneId(i, from);
                          plane.body = is_hand_sampled ? d.field : d.sampled;
                          plane.gap_m = glm::dot(n_W, p_W - X_WG * glm::dvec3(from.q_G));
                          plane.p_W = is_hand_sampled ? p_W : p_W - plane.gap_m * n_W;
                          plane.n_W = is_hand_sampled ? n_W : -n_W;
                          plane.friction = d.friction;
                          PutNearest(plane, &contact->planes);
                        }
                      });
}

void CollisionWorld::FillContactSet(std::size_t pair_index, core::ContactSet* message) const {
  const PairEntry& pair = impl_->pairs[pair_index];
  message->pair_index = static_cast<std::uint16_t>(pair_index);
  message->sampled_body = pair.description.sampled;
  message->field_body = pair.description.field;
  message->cycle = pair.result.cycle;
  message->signed_distance_m = signed_distance_m(pair_index);
  message->is_in_contact = pair.result.is_in_contact;
  message->F_So_W = pair.result.F_So_W;
  message->damping_N_s_per_m = static_cast<float>(pair.description.damping_N_s_per_m);
  message->friction = static_cast<float>(pair.description.friction);
  message->planes = pair.result.planes;
}

double CollisionWorld::RestPenetration_m(std::size_t pair) const {
  return 0.5 * impl_->objects[impl_->pairs[pair].description.field]->voxel_size_m();
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
  return impl_->phases[pair] != PairState::kInactive;
}
bool CollisionWorld::is_fresh(std::size_t pair) const {
  return impl_->pairs[pair].result.cycle == impl_->cycle;
}
double CollisionWorld::signed_distance_m(std::size_t i) const {
  const PairEntry& pair = impl_->pairs[i];
  if (!pair.description.is_active || !pair.result.planes.empty()) return pair.result.signed_distance_m;
  return pair.description.look_ahead_m + impl_->schedule.FreeDistance_m(i);
}
double CollisionWorld::ApartAtLeast_m(std::size_t i) const {
  const PairEntry& pair = impl_->pairs[i];
  return pair.result.planes.empty() ? std::max(0.0, signed_distance_m(i)) : pair.description.look_ahead_m;
}
PairState CollisionWorld::state(std::size_t pair) const {
  const PairState phase = impl_->phases[pair];
  return phase == PairState::kInactive || impl_->schedule.HasMoved(pair) ? phase : PairState::kAsleep;
}
std::array<std::uint32_t, kNumPairStates> CollisionWorld::CountStates() const {
  std::array<std::uint32_t, kNumPairStates> counts{};
  for (std::size_t i = 0; i < num_pairs(); ++i) ++counts[static_cast<std::size_t>(state(i))];
  return counts;
}
const core::Wrench& CollisionWorld::ObjectWrench(std::size_t object) const {
  return impl_->F_Oo_W[object];
}

}  // namespace vps
