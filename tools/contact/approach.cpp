#include "tools/contact/approach.hpp"

#include <algorithm>

#include "tools/contact/smooth_walk.hpp"
#include "vps/oracle/first_touch.hpp"
#include "vps/pointshell/pointshell.hpp"
#include "vps/query/tree_query.hpp"
#include "vps/tree/build_tree.hpp"
#include "vps/voxmap/build_voxmap.hpp"

namespace contact {

std::vector<core::Pose> Approach(const Parts& parts, double least_depth_m, double greatest_depth_m, int count,
                                 vps::CaseRandom* random) {
  const vps::oracle::MeshDistance A(parts.A);
  const vps::oracle::MeshDistance B(parts.B);
  const vps::Box box_A = vps::BoundingBox(parts.A);
  const vps::Box box_B = vps::BoundingBox(parts.B);
  std::vector<core::Pose> poses;
  while (static_cast<int>(poses.size()) < count) {
    const glm::dvec3 from = random->Direction();
    const auto touch = vps::oracle::FindFirstTouch(A, box_A, B, box_B, random->Rotation(), from);
    if (touch) poses.push_back(touch->Beyond(random->Uniform(least_depth_m, greatest_depth_m)));
  }
  return poses;
}

std::vector<std::vector<core::Pose>> WanderInBand(const Parts& parts, const std::vector<core::Pose>& starts,
                                                  double step_m, double least_depth_m, double greatest_depth_m,
                                                  int steps, vps::CaseRandom* random) {
  const vps::Box box_A = vps::BoundingBox(parts.A);
  const glm::dvec3 size = box_A.upper - box_A.lower;
  const auto layers = vps::BuildVoxmap(parts.A, std::max({size.x, size.y, size.z}) / 200.0);
  const auto shell = vps::BuildPointshell(parts.B, 8192);
  if (!layers || !shell) return {};
  const vps::PointTree points = vps::BuildTree(*shell);
  vps::QueryScratch scratch(points);
  const vps::Box box_B = vps::BoundingBox(parts.B);
  const glm::dvec3 centre_B = 0.5 * (box_B.lower + box_B.upper);
  const double radius_m = 0.5 * glm::length(box_B.upper - box_B.lower);
  const double margin_m = std::max(0.0, -least_depth_m);
  // Three lengths and three angles share the step.
  const double length_m = 0.33 * step_m;
  const double angle = 0.5 * step_m / radius_m;
  std::vector<std::vector<core::Pose>> walks;
  for (const core::Pose& start : starts) {
    const auto pose_of = [&](const Coordinates& c) {
      core::Pose X;
      X.rotation = glm::normalize(core::QuaternionFromRotationVector({c[3], c[4], c[5]}) * start.rotation);
      X.translation = start * centre_B + glm::dvec3(c[0], c[1], c[2]) - X.rotation * centre_B;
      return X;
    };
    const auto is_allowed = [&](const Coordinates& c) {
      if (least_depth_m < -0.01) return true;
      const vps::QueryResult q = vps::QueryTree(points, *layers, pose_of(c), margin_m, &scratch);
      const double depth_m = q.num_hits > 0 ? static_cast<double>(q.max_penetration_m) : -margin_m - 1e-9;
      return depth_m >= least_depth_m && depth_m <= greatest_depth_m;
    };
    std::vector<core::Pose> walk;
    for (const Coordinates& c :
         SmoothWalk({}, {length_m, length_m, length_m, angle, angle, angle}, steps, is_allowed, random)) {
      walk.push_back(pose_of(c));
    }
    walks.push_back(std::move(walk));
  }
  return walks;
}

}  // namespace contact
