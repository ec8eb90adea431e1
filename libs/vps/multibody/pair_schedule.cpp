#include "vps/multibody/pair_schedule.hpp"

#include <algorithm>

#include "vps/walk/walk_memory.hpp"

namespace vps {
namespace {

// Sums of odometers are rounded; after a year at 1 m/s by a nanometre.
constexpr double kRounding_m = 1e-8;
// Least pace that the free distance is shared by, so that an object at rest gets a share, too. Not derived: 1 mm/s.
constexpr double kLeastPace_m = 1e-6;

}  // namespace

void PairSchedule::AddObject(const core::Pose& X_WO, const glm::dvec3& centre_m, double radius_m) {
  objects_.push_back({X_WO, centre_m, X_WO * centre_m, radius_m, radius_m});
}

void PairSchedule::AddPair(std::uint32_t a, std::uint32_t b, double zone_m) {
  Pair pair;
  pair.a = a;
  pair.b = b;
  pair.zone_m = zone_m;
  Object& A = objects_[a];
  Object& B = objects_[b];
  B.reach_m = std::max(B.reach_m, B.radius_m + zone_m);
  pair.slot_a = static_cast<std::uint32_t>(A.pairs.size());
  pair.slot_b = static_cast<std::uint32_t>(B.pairs.size());
  for (Object* object : {&A, &B}) {
    object->pairs.push_back(static_cast<std::uint32_t>(pairs_.size()));
    object->readings_m.push_back(kNever);
  }
  pairs_.push_back(pair);
}

void PairSchedule::Finish() {
  passed_ = woken_ = held_ = selected_ = PairBits(pairs_.size());
  due_.reserve(pairs_.size());
  for (std::size_t i = 0; i < pairs_.size(); ++i) Wake(i);
}

void PairSchedule::SetPose(std::size_t index, const core::Pose& X_WO) {
  Object& object = objects_[index];
  if (object.X_WO.rotation == X_WO.rotation && object.X_WO.translation == X_WO.translation) return;
  object.travel_m += MotionBound(object.X_WO, object.centre_W, X_WO, object.centre_m, object.reach_m) * (1.0 + 1e-12);
  object.X_WO = X_WO;
  object.centre_W = X_WO * object.centre_m;
}

const std::vector<std::uint32_t>& PairSchedule::Collect() {
  for (Object& object : objects_) {
    object.has_moved = object.travel_m != object.travel_then_m;
    if (!object.has_moved) continue;
    object.pace_m = object.travel_m - object.travel_then_m;
    object.travel_then_m = object.travel_m;
    if (!(object.travel_m < object.least_reading_m)) FindPassed(&object);
  }
  passed_.ForEach([this](std::size_t pair) { ShareOut(pair, FreeDistance_m(pair)); });
  passed_.ClearAll();
  selected_ = woken_;
  selected_.Add(held_);
  due_.clear();
  selected_.ForEach([this](std::size_t pair) { due_.push_back(static_cast<std::uint32_t>(pair)); });
  return due_;
}

void PairSchedule::FindPassed(Object* object) {
  double least_m = kNever;
  for (std::size_t k = 0; k < object->pairs.size(); ++k) {
    if (object->travel_m < object->readings_m[k]) {
      least_m = std::min(least_m, object->readings_m[k]);
    } else {
      passed_.Set(object->pairs[k]);
    }
  }
  object->least_reading_m = least_m;
}

void PairSchedule::SetReadings(const Pair& pair, double a_m, double b_m) {
  Object& A = objects_[pair.a];
  Object& B = objects_[pair.b];
  A.readings_m[pair.slot_a] = a_m;
  B.readings_m[pair.slot_b] = b_m;
  A.least_reading_m = std::min(A.least_reading_m, a_m);
  B.least_reading_m = std::min(B.least_reading_m, b_m);
}

void PairSchedule::ShareOut(std::size_t index, double free_distance_m) {
  const Pair& pair = pairs_[index];
  free_distance_m -= kRounding_m;
  if (!(free_distance_m > 0.0)) {
    SetReadings(pair, kNever, kNever);
    woken_.Set(index);
    return;
  }
  const Object& A = objects_[pair.a];
  const Object& B = objects_[pair.b];
  const double pace_a_m = A.pace_m + kLeastPace_m;
  const double share_a_m = free_distance_m * (pace_a_m / (pace_a_m + B.pace_m + kLeastPace_m));
  SetReadings(pair, A.travel_m + share_a_m, B.travel_m + (free_distance_m - share_a_m));
}

void PairSchedule::Rest(std::size_t index, double free_m) {
  Stop(index);
  pairs_[index].free_m = free_m;
  ShareOut(index, free_m);
}

void PairSchedule::Hold(std::size_t index) {
  Stop(index);
  held_.Set(index);
}

void PairSchedule::Stop(std::size_t index) {
  Pair& pair = pairs_[index];
  pair.free_m = 0.0;
  pair.travel_m = objects_[pair.a].travel_m + objects_[pair.b].travel_m;
  held_.Clear(index);
  woken_.Clear(index);
  SetReadings(pair, kNever, kNever);
}

double PairSchedule::BallGap(std::size_t index) const {
  const Pair& pair = pairs_[index];
  const Object& A = objects_[pair.a];
  const Object& B = objects_[pair.b];
  return glm::length(A.centre_W - B.centre_W) - A.radius_m - B.radius_m - pair.zone_m;
}

}  // namespace vps
