#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "bus/rt/worker_pool.hpp"
#include "tools/contact/accuracy_race.hpp"
#include "tools/contact/studies.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/testing/wrench_cases.hpp"

namespace contact {
namespace {

constexpr double kStep_m = 1e-6;
constexpr int kSteps = 200;  // not derived: longer takes longer
constexpr int kTrend = 10;   // steps over which the smooth change is taken; not derived: a hundredth of a millimetre
constexpr double kMostOverSmooth = 2.0;
constexpr double kMostOfForce = 0.002;
constexpr double kAccuracies[] = {0.1, kAccuracy};
constexpr const char* kMotions[] = {"approach", "slide", "turn"};
constexpr const char* kFamilies[] = {"bevelled", "threaded",   "thin_walled", "sharp",  "sheets",
                                     "needles",  "long_edges", "pegs",        "scanned"};
// Of the families' cases, one pose of each of these kinds.
constexpr vps::PoseKind kKinds[] = {vps::PoseKind::kMedium, vps::PoseKind::kFlat, vps::PoseKind::kEdge,
                                    vps::PoseKind::kPressed};

// Two parts and the poses at which the motions begin.
struct Pair {
  std::string kind;  // the row: a workload, or a family of parts
  Parts parts;
  std::uint32_t num_points = kMiddlePoints;
  std::vector<core::Pose> starts;
};

// Poses X_AB, `kStep_m` from one to the next, from kTrend before the start on: of B's middle, or of the place of B that
// is farthest from the axis.
std::vector<core::Pose> Motion(const std::string& motion, const core::Pose& start, const glm::dvec3& from_A,
                               const vps::TriangleMesh& B, vps::CaseRandom* random) {
  const vps::Box box = vps::BoundingBox(B);
  const glm::dvec3 middle = 0.5 * (box.lower + box.upper);
  glm::dvec3 along = -from_A;
  if (motion == "slide") along = glm::normalize(glm::cross(from_A, random->Direction()));
  const glm::dvec3 axis = random->Direction();
  double rim_m = 0.0;
  for (const glm::dvec3& v : B.vertices) rim_m = std::max(rim_m, glm::length(glm::cross(axis, v - middle)));
  std::vector<core::Pose> poses;
  for (int i = -kTrend; i <= kSteps; ++i) {
    core::Pose X = start;
    if (motion == "turn") {
      X.rotation = glm::normalize(start.rotation * core::QuaternionFromRotationVector(kStep_m / rim_m * i * axis));
      X.translation = start * middle - X.rotation * middle;
    } else {
      X.translation += kStep_m * i * along;
    }
    poses.push_back(X);
  }
  return poses;
}

// The steps of one motion, or of several.
struct Steps {
  std::size_t count = 0, num_bad = 0, num_felt = 0;   // felt: of the bad ones
  double worst_share = 0.0;                           // of the force
  double worst_excess = 0.0;                          // over what is allowed: 1 is the limit
  double share_there = 0.0, over_smooth_there = 0.0;  // of the step with that

  void Add(const Steps& other) {
    count += other.count;
    num_bad += other.num_bad;
    num_felt += other.num_felt;
    worst_share = std::max(worst_share, other.worst_share);
    if (other.worst_excess <= worst_excess) return;
    worst_excess = other.worst_excess;
    share_there = other.share_there;
    over_smooth_there = other.over_smooth_there;
  }
};

// A step |F(i+1) - F(i)| against the force, and against the smooth change: the mean change |F(j + n) - F(j)| / n over
// the n steps before it or after it, whichever is more. A jump in those counts with an n-th of itself. Below a
// millionth of the force a change is rounding.
Steps StepsOf(const std::vector<glm::dvec3>& F, double felt_m3) {
  constexpr double kRounding = 1e-6;
  Steps out;
  const auto mean_change = [&](std::size_t from) { return glm::distance(F[from], F[from + kTrend]) / kTrend; };
  for (std::size_t i = kTrend; i + 1 + kTrend < F.size(); ++i) {
    const double step = glm::distance(F[i], F[i + 1]);
    const double force = std::max(glm::length(F[i]), glm::length(F[i + 1]));
    if (!(force > 0.0)) continue;
    const double smooth = std::max(mean_change(i - kTrend), mean_change(i + 1));
    const double share = step / force;
    const double over_smooth = step / std::max(smooth, kRounding * force);
    const double excess = std::min(share / kMostOfForce, over_smooth / kMostOverSmooth);
    ++out.count;
    out.num_bad += excess > 1.0 ? 1 : 0;
    out.num_felt += excess > 1.0 && step > felt_m3 ? 1 : 0;
    out.worst_share = std::max(out.worst_share, share);
    if (excess <= out.worst_excess) continue;
    out.worst_excess = excess;
    out.share_there = share;
    out.over_smooth_there = over_smooth;
  }
  return out;
}

// What no hand feels, where the least area carries (AreaScale): the force is stiffness * integral / (rho * area).
double Felt_m3(const vps::TriangleMesh& B) {
  constexpr double kRho = 0.01;  // as scenarios have it, unless they say otherwise
  const vps::PairDescription pair;
  return pair.negligible_N * kRho * vps::SurfaceArea_m2(B) / pair.stiffness_N_per_m;
}

// Of a pair, by motion and accuracy.
using PairSteps = std::array<std::array<Steps, std::size(kAccuracies)>, std::size(kMotions)>;

PairSteps Measure(const Pair& pair) {
  PairSteps all;
  Structures structures(pair.parts);
  const auto A = structures.Get({false, vps::Method::kFast, pair.parts.voxel_size_m, 0});
  const auto B = structures.Get({true, vps::Method::kFast, 0.0, pair.num_points});
  if (!A || !B) return all;
  vps::CaseRandom random(11);
  for (const core::Pose& start : pair.starts) {
    const glm::dvec3 force = MakeFastMethod(*A, *B)->Query(start).force_A;
    if (!(glm::length(force) > 0.0)) continue;
    for (std::size_t m = 0; m < std::size(kMotions); ++m) {
      const auto poses = Motion(kMotions[m], start, glm::normalize(force), pair.parts.B, &random);
      for (std::size_t a = 0; a < std::size(kAccuracies); ++a) {
        const auto method = MakeFastMethod(*A, *B, AsInScenarios(kAccuracies[a]));
        std::vector<glm::dvec3> forces;
        for (const core::Pose& X_AB : poses) forces.push_back(method->Query(X_AB).force_A);
        all[m][a].Add(StepsOf(forces, Felt_m3(pair.parts.B)));
      }
    }
  }
  return all;
}

// The workloads in which parts touch, from two poses each.
std::vector<Pair> PairsOfWorkloads(const PartsSource& parts, Report* report) {
  constexpr std::size_t kStarts = 2;
  std::vector<Pair> pairs;
  for (const std::string& name : PartsNames()) {
    const core::Result<PartsAndWorkloads>& made = parts(name);
    if (!made) {
      report->skipped.push_back("steps, " + name + ": " + made.error().detail);
      continue;
    }
    for (const Workload& w : made->workloads) {
      if (w.fit == Fit::kNear || w.fit == Fit::kApart) continue;
      pairs.push_back({w.name, *made->parts, kMiddlePoints, {w.independent.begin(), w.independent.begin() + kStarts}});
    }
  }
  return pairs;
}

// The held-out set of those families, voxels as `oos query` chooses them. To sample 65,536 points takes seconds a part.
// Most of the time goes into finding poses: side by side.
std::vector<Pair> PairsOfFamilies(const Places& places, Report* report) {
  constexpr std::uint32_t kFewerPoints = kMiddlePoints / 4;
  struct Job {
    const Places& places;
    std::vector<core::Result<std::vector<vps::WrenchCase>>> cases;
  } job{places, {}};
  job.cases.resize(std::size(kFamilies));
  bus::WorkerPool workers(2, "poses");
  workers.Run(
      job.cases.size(),
      [](void* context, std::size_t i) {
        Job& todo = *static_cast<Job*>(context);
        todo.cases[i] = vps::MakeWrenchCases(kFamilies[i], vps::CaseSet::kHeldOut, 1, todo.places.meshes);
      },
      &job);
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < job.cases.size(); ++i) {
    if (!job.cases[i]) {
      report->skipped.push_back(std::string("steps, ") + kFamilies[i] + ": " + job.cases[i].error().detail);
      continue;
    }
    for (const vps::WrenchCase& c : *job.cases[i]) {
      Pair pair{c.family, {c.name, c.A, c.B, UsualResolution(c.A, c.B).voxel_size_m}, kFewerPoints, {}};
      for (const vps::ContactPose& pose : c.poses) {
        if (std::find(std::begin(kKinds), std::end(kKinds), pose.kind) != std::end(kKinds)) {
          pair.starts.push_back(pose.X_AB);
        }
      }
      pairs.push_back(std::move(pair));
    }
  }
  return pairs;
}

std::vector<PairSteps> MeasureAll(const std::vector<Pair>& pairs) {
  struct Job {
    const std::vector<Pair>& pairs;
    std::vector<PairSteps> steps;
  } job{pairs, std::vector<PairSteps>(pairs.size())};
  bus::WorkerPool workers(2, "steps");
  workers.Run(
      pairs.size(),
      [](void* context, std::size_t i) {
        Job& todo = *static_cast<Job*>(context);
        todo.steps[i] = Measure(todo.pairs[i]);
      },
      &job);
  return std::move(job.steps);
}

}  // namespace

void StudySteps(const PartsSource& parts, const Places& places, Report* report) {
  std::vector<Pair> pairs = PairsOfWorkloads(parts, report);
  const std::vector<Pair> families = PairsOfFamilies(places, report);
  pairs.insert(pairs.end(), families.begin(), families.end());
  const std::vector<PairSteps> measured = MeasureAll(pairs);
  Table table{"steps",
              {"pair", "motion", "accuracy", "steps", "beyond_both", "beyond_and_felt", "worst_share_of_force",
               "share_there", "over_smooth_there"},
              {}};
  for (std::size_t a = 0; a < std::size(kAccuracies); ++a) {
    const std::string percent = Short(100.0 * kAccuracies[a]) + " %";
    for (std::size_t m = 0; m < std::size(kMotions); ++m) {
      Steps worst;
      std::string worst_at;
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        Steps steps;  // of all cases of a family
        if (i > 0 && pairs[i].kind == pairs[i - 1].kind) continue;
        for (std::size_t k = i; k < pairs.size() && pairs[k].kind == pairs[i].kind; ++k) steps.Add(measured[k][m][a]);
        table.Add({pairs[i].kind, kMotions[m], Cell(kAccuracies[a]), std::to_string(steps.count),
                   std::to_string(steps.num_bad), std::to_string(steps.num_felt), Cell(steps.worst_share),
                   Cell(steps.share_there), Cell(steps.over_smooth_there)});
        std::printf(
            "steps, %s, %s, %s: %zu of %zu beyond both, %zu felt; worst %s %% of the force, %s x the smooth change\n",
            pairs[i].kind.c_str(), kMotions[m], percent.c_str(), steps.num_bad, steps.count, steps.num_felt,
            Short(100.0 * steps.share_there).c_str(), Short(steps.over_smooth_there).c_str());
        if (steps.worst_excess > worst.worst_excess) worst_at = pairs[i].kind;
        worst.Add(steps);
      }
      report->AddGoal(std::string("force step at 1 um of ") + kMotions[m] + ", all shapes, " + percent,
                      "<= 2 x the smooth change, or <= 0.2 % of the force",
                      Short(worst.over_smooth_there) + " x, " + Short(100.0 * worst.share_there) + " % at worst (" +
                          worst_at + "); beyond both: " + std::to_string(worst.num_bad) + " of " +
                          std::to_string(worst.count) + " steps, felt: " + std::to_string(worst.num_felt),
                      worst.num_bad == 0);
    }
  }
  report->tables.push_back(table);
}

}  // namespace contact
