// F22: a budget of points that does not suffice.
#include <algorithm>
#include <cmath>

#include "core/clock.hpp"
#include "tools/failures/field_pair.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr std::uint32_t kPoints = 65536;

struct Overload {
  std::vector<double> errors;  // of force and torque, by rising budget
  bool has_deepest = true;     // found, to a hundredth of a voxel, within every budget
  bool is_reported = true;     // every query that was cut short says so
};

// A wavy press: a torus lying tilted in a plate, so that many points touch at many depths.
Overload Cut(const Variant& variant, const std::vector<double>& budgets_us) {
  FieldPair pair(variant, vps::MakeBox({0.2, 0.2, 0.04}), kVoxel_m, vps::MakeTorus(0.05, 0.02, 192, 96), kPoints);
  const core::Pose X_GS{core::QuaternionFromRotationVector({0.004, 0.002, 0.3}), {0, 0, 0.02 + 0.02 - 0.0015}};
  const auto away = X_GS * core::Pose{{1, 0, 0, 0}, {0, 0, 1e-7}};
  // Time of a point: the median of full queries.
  std::vector<double> us_per_point;
  vps::PairResult full;
  for (int i = 0; i < 31; ++i) {
    pair.Query(away);
    const std::int64_t begin_ns = core::ThreadCpuNow_ns();
    full = pair.Query(X_GS);
    us_per_point.push_back(1e-3 * static_cast<double>(core::ThreadCpuNow_ns() - begin_ns) /
                           static_cast<double>(std::max<std::uint64_t>(1, full.counters.points_tested)));
  }
  std::nth_element(us_per_point.begin(), us_per_point.begin() + 15, us_per_point.end());
  Overload overload;
  for (const double budget_us : budgets_us) {
    const auto points = static_cast<std::uint64_t>(budget_us / us_per_point[15]);
    pair.Query(away);
    const vps::PairResult& cut = pair.Query(X_GS, std::max<std::uint64_t>(1, points));
    const double force = glm::length(full.F_So_W.force_N);
    overload.errors.push_back(std::max(glm::length(cut.F_So_W.force_N - full.F_So_W.force_N) / force,
                                       glm::length(cut.F_So_W.torque_Nm - full.F_So_W.torque_Nm) / (0.05 * force)));
    overload.has_deepest = overload.has_deepest && cut.signed_distance_m <= full.signed_distance_m + 0.01 * kVoxel_m;
    const bool is_less = cut.counters.points_tested < full.counters.points_tested;
    overload.is_reported = overload.is_reported && (!is_less || cut.is_cut_short);
  }
  return overload;
}

}  // namespace

void StudyOverload(Report* report) {
  Row row{"F22",
          "overload",
          "tilted torus of 64k points pressed into a plate, time for 5, 10, 25, 50, 100 us of points",
          "error of the wrench; deepest point kept; overflow reported",
          "falls; yes; yes",
          {},
          "`paper` has no budget of points: it tests all of them"};
  for (const Variant& variant : Variants()) {
    const Overload overload = Cut(variant, {5.0, 10.0, 25.0, 50.0, 100.0});
    std::string text;
    for (const double error : overload.errors) text += (text.empty() ? "" : ", ") + Short(100.0 * error) + " %";
    const bool is_falling = std::is_sorted(overload.errors.rbegin(), overload.errors.rend());
    row.readings.push_back(
        {variant.name,
         text + "; " + (overload.has_deepest ? "yes" : "no") + "; " + (overload.is_reported ? "yes" : "no"),
         is_falling && overload.has_deepest && overload.is_reported});
  }
  AddRow(report, row);
}

}  // namespace failures
