#include "tools/contact/training_planes.hpp"

#include <algorithm>
#include <limits>

#include "vps/multibody/gap_query.hpp"

namespace contact {
namespace {

constexpr double kMoved_m = 3e-5;  // in three cycles at a centimetre a second
constexpr double kFelt_N = 0.1;    // ten times what does not count (PairDescription::negligible_N)
constexpr double kRho = 0.01;      // WorldDescription's

core::Pose MovedOn(core::Pose X_AB, int side) {
  X_AB.translation[side / 2] += side % 2 == 0 ? kMoved_m : -kMoved_m;
  return X_AB;
}

double Gap_m(const core::ContactPlane& plane, const core::Pose& X_AB) {
  return glm::dot(glm::dvec3(plane.n_G), X_AB * glm::dvec3(plane.p_S) - glm::dvec3(plane.q_G));
}

// The world frame is A's, moments are about B's origin.
class LoadEngine {
 public:
  LoadEngine(const Cooked& A, const Cooked& B) : A_(*A), B_(*B), scratch_(*B->samples) { scratch_.memory = &memory_; }
  void Forget() { memory_ = {}; }
  const vps::PairResult& Query(const core::Pose& X_AB) {
    vps::QueryFastPair(vps::FastPairOf(B_, A_, memory_), X_AB, X_AB, pair_, kRho, &scratch_, &result_);
    return result_;
  }
  [[nodiscard]] core::Wrench WrenchOfPlanes(const core::Pose& X_AB) const {
    core::Wrench wrench;
    for (const core::ContactPlane& plane : result_.planes) {
      const double load_N = -Gap_m(plane, X_AB) * static_cast<double>(plane.stiffness_N_per_m);
      if (!(load_N > 0.0)) continue;
      const glm::dvec3 force_N = load_N * glm::dvec3(plane.n_G);
      const glm::dvec3 lever_m = X_AB * glm::dvec3(plane.p_S) - X_AB.translation;
      wrench += core::Wrench{force_N, glm::cross(lever_m, force_N)};
    }
    return wrench;
  }

 private:
  const vps::CookedObject& A_;
  const vps::CookedObject& B_;
  vps::PairDescription pair_;
  vps::TouchMemory memory_;
  vps::FastPairScratch scratch_;
  vps::PairResult result_;
};

class GapEngine {
 public:
  GapEngine(const Cooked& A, const Cooked& B, const vps::TouchPoints& touch)
      : parts_{touch.tree, *B->surface, *A->field, *A->bends}, touch_(touch), scratch_(touch.tree) {
    scratch_.gaps = std::make_unique<vps::GapScratch>();
  }
  void Forget() { gaps_.Clear(); }
  const vps::GapPlanes& Query(const core::Pose& X_AB) {
    scratch_.found = vps::WalkField(touch_.tree, parts_.field, X_AB, vps::WalkMargin_m(touch_.tree, pair_.look_ahead_m),
                                    &scratch_.walk);
    vps::FinishGapPair(parts_, touch_, X_AB, X_AB, pair_, kRho, &scratch_, &gaps_, &result_);
    return gaps_;
  }
  [[nodiscard]] double LeastGap_m(const core::Pose& X_AB) const {
    double least_m = std::numeric_limits<double>::infinity();
    for (const core::ContactPlane& plane : gaps_.planes) least_m = std::min(least_m, Gap_m(plane, X_AB));
    return least_m;
  }

 private:
  vps::FastPair parts_;
  const vps::TouchPoints& touch_;
  vps::PairDescription pair_;
  vps::FastPairScratch scratch_;
  vps::GapPlanes gaps_;
  vps::PairResult result_;
};

void MeasureLoads(const std::vector<core::Pose>& way, double radius_B_m, LoadEngine* here, LoadEngine* there,
                  PlaneFigures* figures) {
  here->Forget();
  std::size_t num_planes = 0;
  for (const core::Pose& pose : way) num_planes = here->Query(pose).planes.size();
  figures->num_planes.push_back(static_cast<double>(num_planes));
  for (int side = 0; side < 6; ++side) {
    const core::Pose X_AB = MovedOn(way.back(), side);
    there->Forget();
    const core::Wrench& wanted = there->Query(X_AB).F_So_W;
    const double force_N = glm::length(wanted.force_N);
    if (force_N < kFelt_N) continue;
    const core::Wrench found = here->WrenchOfPlanes(X_AB);
    figures->force.push_back(glm::length(found.force_N - wanted.force_N) / force_N);
    figures->moment.push_back(glm::length(found.torque_Nm - wanted.torque_Nm) / (force_N * radius_B_m));
  }
}

void MeasureGaps(const std::vector<core::Pose>& way, GapEngine* here, GapEngine* there, PlaneFigures* figures) {
  here->Forget();
  std::size_t num_planes = 0;
  for (const core::Pose& pose : way) num_planes = here->Query(pose).planes.size();
  figures->num_gap_planes.push_back(static_cast<double>(num_planes));
  if (num_planes == 0) return;
  for (int side = 0; side < 6; ++side) {
    const core::Pose X_AB = MovedOn(way.back(), side);
    there->Forget();
    if (there->Query(X_AB).planes.empty()) continue;
    figures->gap.push_back(std::abs(here->LeastGap_m(X_AB) - there->LeastGap_m(X_AB)) / kMoved_m);
  }
}

}  // namespace

void MeasurePlanes(const Cooked& A, const Cooked& B, double radius_B_m,
                   const std::vector<std::vector<core::Pose>>& ways, PlaneFigures* figures) {
  const vps::TouchPoints touch = vps::FindTouchPoints(*B->samples, *B->surface);
  LoadEngine loads_here(A, B), loads_there(A, B);
  GapEngine gaps_here(A, B, touch), gaps_there(A, B, touch);
  for (const std::vector<core::Pose>& way : ways) {
    MeasureLoads(way, radius_B_m, &loads_here, &loads_there, figures);
    MeasureGaps(way, &gaps_here, &gaps_there, figures);
  }
}

}  // namespace contact
