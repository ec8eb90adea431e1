#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/clock.hpp"
#include "tools/contact/studies.hpp"
#include "vps/walk/field_walk.hpp"

namespace contact {
namespace {

// Not derived: length of a run against scatter of the medians.
constexpr int kPasses = 7;
constexpr std::size_t kPosesOfWalk = 30;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// The walk alone, without contact planes, with one instruction set.
class WalkMethod : public Method {
 public:
  WalkMethod(const vps::SampleTree& samples, const vps::DistanceField& field, vps::InstructionSet set)
      : samples_(samples), field_(field), scratch_(samples, set) {}
  Answer Query(const core::Pose& X_AB) override {
    const vps::FieldWalkResult walk = vps::WalkField(samples_, field_, X_AB, 0.0, &scratch_);
    Answer answer;
    answer.force_A = X_AB.rotate(walk.force_m3);
    answer.points_tested = walk.points_tested;
    return answer;
  }

 private:
  const vps::SampleTree& samples_;
  const vps::DistanceField& field_;
  vps::FieldWalkScratch scratch_;
};

// The same points under spheres of 1 km: none is culled, so the same kernel tests all points.
vps::SampleTree WithoutCulling(vps::SampleTree samples) {
  for (vps::SphereBlock& block : samples.spheres) {
    for (std::uint32_t k = 0; k < vps::kBlock; ++k) {
      if (std::abs(block.x[k]) < 1e3f) block.r[k] = 1e3f;
      block.nx[k] = block.ny[k] = block.nz[k] = block.h[k] = 0.0f;
    }
  }
  return samples;
}

// Indices into the field's words of `num_tested` points: those of the blocks nearest to the surface, which a query
// tests.
std::vector<std::uint32_t> TestedWords(const vps::SampleTree& samples, const vps::DistanceField& field,
                                       const core::Pose& X_AB, std::uint64_t num_tested) {
  const vps::FieldTransform T(X_AB, field);
  std::vector<std::pair<float, std::uint32_t>> blocks;
  for (std::uint32_t b = 0; b < samples.points.size(); ++b) {
    float nearest = 1e30f;
    for (std::uint32_t k = 0; k < vps::kBlock; ++k) {
      const vps::PointBlock& p = samples.points[b];
      nearest = std::min(nearest, vps::SampleField(field, T.ToVoxels({p.x[k], p.y[k], p.z[k]})).distance);
    }
    blocks.emplace_back(nearest, b);
  }
  const std::size_t count = std::min<std::size_t>(num_tested / vps::kBlock, blocks.size());
  std::nth_element(blocks.begin(), blocks.begin() + static_cast<std::ptrdiff_t>(count), blocks.end());
  blocks.resize(count);
  std::sort(blocks.begin(), blocks.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  std::vector<std::uint32_t> words;
  for (const auto& [unused, b] : blocks) {
    for (std::uint32_t k = 0; k < vps::kBlock; ++k) {
      const vps::PointBlock& p = samples.points[b];
      const glm::vec3 v = T.ToVoxels({p.x[k], p.y[k], p.z[k]});
      const glm::ivec3 c = glm::clamp(glm::ivec3(v), glm::ivec3(0), glm::ivec3(field.nx, field.ny, field.nz) - 1);
      const auto brick =
          static_cast<std::size_t>(((c.z >> 3) * (field.ny >> 3) + (c.y >> 3)) * (field.nx >> 3) + (c.x >> 3));
      words.push_back(field.bricks[brick] + vps::WordInBrick(c.x, c.y, c.z));
    }
  }
  return words;
}

// Median time to read and add those words, the indices computed beforehand.
double GatherTime_us(const vps::DistanceField& field, const std::vector<std::vector<std::uint32_t>>& words) {
  const OneCore pinned;
  std::vector<double> times;
  volatile std::uint32_t sink = 0;
  for (int pass = 0; pass < kPasses + 1; ++pass) {
    for (const auto& of_pose : words) {
      const std::int64_t start_ns = core::MonotonicNow_ns();
      std::uint32_t sum[4] = {0, 0, 0, 0};
      for (std::size_t i = 0; i + 3 < of_pose.size(); i += 4) {
        for (std::size_t k = 0; k < 4; ++k) sum[k] += field.words[of_pose[i + k]];
      }
      sink = sink + sum[0] + sum[1] + sum[2] + sum[3];
      if (pass > 0) times.push_back(1e-3 * static_cast<double>(core::MonotonicNow_ns() - start_ns));
    }
  }
  return Quantile(times, 0.5);
}

// max over poses of (median time of a - median time of b). Both take turns, so that interrupts fall on both alike.
double WorstExcess_us(Method* a, Method* b, const std::vector<core::Pose>& poses) {
  const OneCore pinned;
  std::vector<std::vector<double>> of_a(poses.size()), of_b(poses.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    for (Method* method : {a, b}) {
      auto& times = method == a ? of_a : of_b;
      for (const core::Pose& pose : poses) method->Query(pose);
      for (std::size_t i = 0; i < poses.size(); ++i) {
        const std::int64_t start_ns = core::MonotonicNow_ns();
        method->Query(poses[i]);
        times[i].push_back(1e-3 * static_cast<double>(core::MonotonicNow_ns() - start_ns));
      }
    }
  }
  double worst = -1e30;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    worst = std::max(worst, Quantile(of_a[i], 0.5) - Quantile(of_b[i], 0.5));
  }
  return worst;
}

}  // namespace

KernelFigures StudyKernel(const Workload& workload, const Parts& parts, Structures* structures) {
  KernelFigures figures{workload.name, workload.fit, kNaN, kNaN, kNaN, kNaN, kNaN, kNaN, kNaN, kNaN, kNaN};
  const auto A = structures->Get({false, vps::Method::kFast, parts.voxel_size_m, 0});
  const auto B = structures->Get({true, vps::Method::kFast, 0.0, kMiddlePoints});
  if (!A || !B) return figures;
  const vps::DistanceField& field = *(*A)->field;
  const vps::SampleTree& samples = *(*B)->samples;
  std::vector<core::Pose> poses;
  for (const auto& walk : workload.walks) {
    poses.insert(poses.end(), walk.begin(),
                 walk.begin() + static_cast<std::ptrdiff_t>(std::min(kPosesOfWalk, walk.size())));
  }
  WalkMethod best(samples, field, vps::BestInstructionSet());
  const vps::SampleTree all = WithoutCulling(samples);
  WalkMethod flat(all, field, vps::BestInstructionSet());
  std::vector<std::unique_ptr<WalkMethod>> sets;
  std::vector<Racer> racers = {{&best, poses, true, {}}, {&flat, poses, true, {}}};
  for (const auto set : {vps::InstructionSet::kPortable, vps::InstructionSet::kAvx2, vps::InstructionSet::kAvx512}) {
    if (!vps::IsAvailable(set)) continue;
    sets.push_back(std::make_unique<WalkMethod>(samples, field, set));
    racers.push_back({sets.back().get(), poses, true, {}});
  }
  Race(racers, kPasses, 1.0);
  figures.query_us = racers[0].times.p50_us;
  figures.flat_us = racers[1].times.p50_us;
  std::size_t at = 2;
  for (double* us : {&figures.portable_us, &figures.avx2_us, &figures.avx512_us}) {
    if (at < racers.size()) *us = racers[at++].times.p50_us;
  }
  figures.worst_excess_us = WorstExcess_us(&best, &flat, poses);
  std::vector<std::vector<std::uint32_t>> words;
  std::vector<double> tested;
  double error = 0.0;
  for (std::size_t i = 0; i < poses.size(); i += 10) {
    const Answer answer = best.Query(poses[i]);
    tested.push_back(static_cast<double>(answer.points_tested));
    words.push_back(TestedWords(samples, field, poses[i], answer.points_tested));
    const glm::dvec3 portable = sets.front()->Query(poses[i]).force_A;
    const double f = glm::length(answer.force_A);
    if (f > 0.0) error = std::max(error, glm::length(portable - answer.force_A) / f);
  }
  figures.portable_relative_error = error;
  figures.tested_points = Quantile(tested, 0.5);
  figures.gather_us = GatherTime_us(field, words);
  std::printf(
      "%s, walk alone: %s us, all points %s us (worst beyond %s us), gather of its %s points %s us, portable %s, "
      "AVX2 %s, AVX-512 %s us\n",
      workload.name.c_str(), Short(figures.query_us).c_str(), Short(figures.flat_us).c_str(),
      Short(figures.worst_excess_us).c_str(), Short(figures.tested_points).c_str(), Short(figures.gather_us).c_str(),
      Short(figures.portable_us).c_str(), Short(figures.avx2_us).c_str(), Short(figures.avx512_us).c_str());
  return figures;
}

void ReportKernels(const std::vector<KernelFigures>& rows, Report* report) {
  if (rows.empty()) return;
  Table table{"kernel",
              {"workload", "walk_us", "flat_us", "worst_beyond_flat_us", "points_tested", "ideal_gather_us",
               "portable_us", "avx2_us", "avx512_us", "portable_relative_error"},
              {}};
  Chart sets{"Walk alone by instruction set", "median of consecutive poses, 64k points", {}};
  Chart limit{"The walk beside two limits",
              "flat: all points tested by the same kernel; gather: only reading the words "
              "of the tested points, their places known",
              {}};
  double worst_excess = -1e30;
  double slowest_avx2 = 1e30;
  double worst_portable = 0.0;
  for (const KernelFigures& k : rows) {
    table.Add({k.workload, Cell(k.query_us), Cell(k.flat_us), Cell(k.worst_excess_us), Cell(k.tested_points),
               Cell(k.gather_us), Cell(k.portable_us), Cell(k.avx2_us), Cell(k.avx512_us),
               Cell(k.portable_relative_error)});
    const auto panel = [&](Chart* chart, const std::vector<std::pair<std::string, double>>& bars) {
      Panel p;
      p.title = k.workload;
      p.x_title = "time per query [us]";
      p.x_log = false;
      for (const auto& [name, us] : bars) {
        if (std::isfinite(us)) p.bars.push_back({name, us, Short(us), name});
      }
      chart->panels.push_back(std::move(p));
    };
    panel(&sets, {{"portable", k.portable_us}, {"AVX2", k.avx2_us}, {"AVX-512", k.avx512_us}});
    panel(&limit, {{"flat", k.flat_us}, {"walk", k.query_us}, {"gather", k.gather_us}});
    worst_excess = std::max(worst_excess, k.worst_excess_us);
    if (std::isfinite(k.avx512_us) && k.avx2_us > 5.0) slowest_avx2 = std::min(slowest_avx2, k.avx512_us / k.avx2_us);
    worst_portable = std::max(worst_portable, k.portable_relative_error);
    if (k.fit == Fit::kConforming) {
      const double factor = k.query_us / k.gather_us;
      report->AddGoal("query against the ideal gather of its own tested points (" + k.workload + ")", "<= 2.5 x",
                      Short(factor) + " x (gather " + Short(1e3 * k.gather_us / k.tested_points) + " ns a point)",
                      factor <= 2.5);
    }
  }
  report->tables.push_back(table);
  report->charts.emplace_back("instruction_sets", sets);
  report->charts.emplace_back("limits", limit);
  report->AddGoal("never slower than a flat scan of the same points, any pose of any workload", "+ 1 us",
                  Short(worst_excess) + " us beyond at worst", worst_excess <= 1.0);
  if (slowest_avx2 < 1e30) {
    report->AddGoal("AVX2 against AVX-512 (workloads above 5 us)", ">= 0.7 x its speed",
                    Short(slowest_avx2) + " x at worst", slowest_avx2 >= 0.7);
  }
  report->AddGoal("portable path against the widest: force", "within 1e-5",
                  Short(worst_portable) + " relative at worst", worst_portable <= 1e-5);
}

}  // namespace contact
