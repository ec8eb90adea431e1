#include "vps/surface/surface_integral.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "vps/field/brick_traits.hpp"
#include "vps/field/nearest_facet.hpp"

namespace vps {
namespace {

// The factors of the estimate, each on a term that README.md derives; chosen on the workloads of `oos bench vps`, and
// judged by others (docs/performance/vps.md).
constexpr float kMissedMean = 0.5f;    // of what a parent mispredicted, in the mean
constexpr float kMissedSpread = 0.5f;  // the same, r.m.s.
constexpr float kUnseenBend = 0.1f;    // of FieldBends' bound, where a parent's prediction was tested
constexpr float kStraddling = 0.05f;   // of a flat node that the surface cuts: error over area times reach
constexpr float kCurved = 1.0f;        // the same, times 1 - |A| / a, the spread of its normals
// SurfaceErrorAt is the larger of the r.m.s. error and six times the mean (ComputeBrickTraits).
constexpr float kMeanOfFieldError = 1.0f / 6.0f;

// Opening a patch takes away about so much of its error: parts half as large bend a quarter as much. Not derived more
// closely: what is left is opened in the next round.
constexpr double kGain = 0.7;
constexpr int kMostRounds = 60;
constexpr std::size_t kMostPatches = 65'536;  // not derived: 25 MB
// Farther inside than this the field's error is small against the depth, and triangles are far, voxels.
constexpr float kDeepestExact = 2.5f;
constexpr double kReachOfTriangles = 3.0;
// An error that does not count whatever was asked for, as a depth over all of S: it ends the search where nothing
// touches. Not derived.
constexpr double kNegligible_m = 1e-11;
// A side that is worth so much more to halve than the least one is halved alone.
constexpr float kAlone = 2.5f;

}  // namespace

void SurfaceIntegral::ReadField(Patch* patch) {
  ++result_.places_read;
  const FieldSample sample = SampleField(G_, InField(patch->node.centre_m));
  patch->depth_m = -sample.distance * voxel_m_;
  patch->slope = -(glm::transpose(R_GS_) * sample.gradient);
}

// The gradient of the distance is the direction from the nearest place; at the place itself, the triangle's normal.
void SurfaceIntegral::ReadTriangles(Patch* patch) {
  ReadField(patch);
  const glm::dvec3 p(InField(patch->node.centre_m));
  const NearestFacet nearest = FindNearestFacet(G_.triangles(), p, kReachOfTriangles);
  if (!nearest.is_found) return;
  const glm::dvec3 away = p - nearest.place;
  const double distance = glm::length(away);
  constexpr double kAtThePlace = 1e-4;  // voxels; the direction of a shorter way is rounding
  const glm::dvec3 gradient = nearest.is_on_face || distance < kAtThePlace
                                  ? nearest.normal
                                  : away / (nearest.height < 0.0 ? -distance : distance);
  patch->depth_m = static_cast<float>(-nearest.height) * voxel_m_;
  patch->slope = -(glm::transpose(R_GS_) * glm::vec3(gradient));
}

// The mean depth of a node differs from that at its centre by  -1/2 trace(H Q) / a,  H the matrix of second derivatives
// of the distance. FieldBends has H in the field's axes; Q is turned there.
void SurfaceIntegral::Integrate(Patch* patch) const {
  const SurfaceNode& node = patch->node;
  const glm::vec3 q = InField(node.centre_m);
  const float reach = node.radius_m * per_voxel_;
  patch->bend = bends_.At(q, std::max(reach, std::abs(patch->depth_m) * per_voxel_));
  float correction_m = 0.0f;
  float bend_m = node.radius_m;
  if (patch->bend != nullptr) {
    const std::array<float, 6>& s = node.spread_m4;
    const glm::mat3 Q(s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2]);
    const glm::mat3 turned = R_GS_ * Q * glm::transpose(R_GS_) * (per_voxel_ * per_voxel_ / node.area_m2);  // voxels^2
    const std::array<float, 6> in_G = {turned[0][0], turned[1][1], turned[2][2],
                                       turned[0][1], turned[0][2], turned[1][2]};
    correction_m = -0.5f * TraceOf(patch->bend->mean, in_G) * voxel_m_;
    bend_m = 0.5f * std::max(0.0f, TraceOf(patch->bend->most, in_G)) * voxel_m_;
    // Below a voxel it is edges that bend, and an edge misses in proportion to the size, not to its square.
    if (reach < 1.0f) bend_m /= std::max(reach, 0.05f);
    bend_m = std::min(bend_m, 2.0f * node.radius_m);
  }
  float depth_m = patch->depth_m;
  // Distances are 1-Lipschitz: farther outside than the radius nothing is inside.
  if (depth_m > -node.radius_m) depth_m = std::max(-node.radius_m, depth_m + correction_m);
  patch->integral = NodeIntegral(node, depth_m, patch->slope);
  EstimateErrors(patch, bend_m, depth_m);
}

void SurfaceIntegral::EstimateErrors(Patch* patch, float bend_m, float depth_m) const {
  const SurfaceNode& node = patch->node;
  float off_m = bend_m;
  float spread_m = 0.0f;
  if (patch->missed_mean_m >= 0.0f) {
    off_m = std::min(kMissedMean * patch->missed_mean_m + kUnseenBend * bend_m, 2.0f * node.radius_m);
    spread_m = kMissedSpread * patch->missed_spread_m;
  }
  // The part of the node that may be inside.
  const float reach_m = node.radius_m + off_m;
  const float inside = std::clamp(0.5f + 0.5f * depth_m / reach_m, 0.0f, 1.0f);
  const float area_m2 = node.area_m2 * inside;
  patch->bias_m3 = area_m2 * off_m;
  patch->variance_m6 = area_m2 * spread_m * area_m2 * spread_m;
  // Where the surface cuts the node: the evenly spread depths of NodeIntegral are not the node's.
  const float cut_m = patch->triangle ? std::min(node.radius_m, 2.0f * patch->integral.half_width_m) : node.radius_m;
  patch->is_straddling = std::abs(depth_m) < cut_m;
  if (patch->is_straddling) {
    const float near = 1.0f - std::abs(depth_m) / cut_m;
    const float curved = 1.0f - glm::length(node.area_vector_m2) / node.area_m2;
    const float error = (kStraddling + kCurved * curved) * node.area_m2 * cut_m * near * near;
    patch->variance_m6 += error * error;
  }
  // The field's own error: its mean is of one sign, the rest is drawn anew in each voxel.
  patch->field_bias_m3 = patch->field_variance_m6 = 0.0f;
  if (!patch->is_exact && inside > 0.0f && std::abs(depth_m) < kDeepestExact * voxel_m_) {
    const float error_m = SurfaceErrorAt(G_, InField(node.centre_m)) * voxel_m_;
    patch->field_bias_m3 = kMeanOfFieldError * error_m * area_m2;
    patch->field_variance_m6 = error_m * error_m * area_m2 * voxel_m_ * voxel_m_;
  }
  patch->bias_m3 += patch->field_bias_m3;
  patch->variance_m6 += patch->field_variance_m6;
}

// A patch that is outside for certain is left out.
void SurfaceIntegral::Offer(Patch patch) {
  Integrate(&patch);
  const bool is_outside = patch.integral.mean_m <= 0.0f && patch.bias_m3 <= 0.0f && patch.variance_m6 <= 0.0f;
  if (!is_outside) front_.push_back(patch);
}

// How much of the error halving a side of a triangle takes away: the bend along it and, where the surface cuts the
// triangle, how much the depth varies along it.
float SurfaceIntegral::WorthOfSide(const Patch& patch, const glm::vec3& side) const {
  float worth = 1e-3f * kStraddling * glm::length(side);
  if (patch.bend != nullptr) {
    const glm::vec3 e = R_GS_ * side * per_voxel_;
    // A triangle's variance along a side of length l is l^2 / 24 for the other two corners in its middle; 1/2 for bend.
    constexpr float kVariance = 1.0f / 48.0f;
    worth += kVariance * std::max(0.0f, glm::dot(e, Times(patch.bend->most, e))) * voxel_m_;
  }
  if (patch.is_straddling) worth += kStraddling * std::abs(glm::dot(patch.slope, side));
  return worth;
}

// The children of a node; four quarters of a triangle, or two halves if one side is worth much more than another.
void SurfaceIntegral::Divide(const Patch& patch, std::vector<Patch>* parts) const {
  parts->clear();
  const auto add = [&](const SurfaceNode& node, const std::optional<SurfacePiece>& triangle) {
    Patch part;
    part.node = node;
    part.triangle = triangle;
    part.is_exact = patch.is_exact;
    parts->push_back(part);
  };
  if (!patch.triangle) {
    for (std::uint32_t i = 0; i < patch.node.num_children; ++i) {
      const SurfaceNode& child = S_.nodes[patch.node.first + i];
      add(child, child.num_children == 0 ? std::optional(S_.triangles[child.first]) : std::nullopt);
    }
    return;
  }
  const auto& c = patch.triangle->corners;
  float worth[3];
  for (int k = 0; k < 3; ++k) worth[k] = WorthOfSide(patch, c[(k + 1) % 3] - c[k]);
  const int best = static_cast<int>(std::max_element(worth, worth + 3) - worth);
  const auto put = [&](const glm::vec3& p, const glm::vec3& q, const glm::vec3& r) {
    const SurfacePiece piece{{p, q, r}};
    add(NodeOf(piece), piece);
  };
  if (worth[best] > kAlone * *std::min_element(worth, worth + 3)) {
    const glm::vec3& a = c[best];
    const glm::vec3& b = c[(best + 1) % 3];
    const glm::vec3& apex = c[(best + 2) % 3];
    const glm::vec3 middle = 0.5f * (a + b);
    put(a, middle, apex);
    put(middle, b, apex);
    return;
  }
  const glm::vec3 ab = 0.5f * (c[0] + c[1]);
  const glm::vec3 bc = 0.5f * (c[1] + c[2]);
  const glm::vec3 ca = 0.5f * (c[2] + c[0]);
  put(c[0], ab, ca);
  put(ab, c[1], bc);
  put(ca, bc, c[2]);
  put(bc, ca, ab);
}

// The parent's model is tested at the centres of its parts: it predicts  d + g . e - 1/2 e^T H e  there. What it
// mispredicts tells how well the parts, half as large, predict within themselves.
void SurfaceIntegral::Open(std::size_t i) {
  const Patch parent = front_[i];
  front_[i].is_open = true;
  Divide(parent, &parts_);
  double sum = 0.0;
  double squares = 0.0;
  double area = 0.0;
  for (Patch& part : parts_) {
    Read(&part);
    const glm::vec3 e = part.node.centre_m - parent.node.centre_m;
    float predicted_m = parent.depth_m + glm::dot(parent.slope, e);
    if (parent.bend != nullptr) {
      const glm::vec3 in_G = R_GS_ * e * per_voxel_;
      predicted_m -= 0.5f * glm::dot(in_G, Times(parent.bend->mean, in_G)) * voxel_m_;
    }
    const auto missed = static_cast<double>(predicted_m - part.depth_m);
    const auto a = static_cast<double>(part.node.area_m2);
    sum += a * missed;
    squares += a * missed * missed;
    area += a;
  }
  for (Patch& part : parts_) {
    part.missed_mean_m = static_cast<float>(std::abs(sum) / area);
    part.missed_spread_m = static_cast<float>(std::sqrt(squares / area));
    Offer(part);
  }
}

SurfaceIntegral::Estimate SurfaceIntegral::EstimateAll() const {
  glm::dvec3 force(0.0);
  double volume = 0.0;
  double variance = 0.0;
  Estimate all;
  for (const Patch& patch : front_) {
    if (patch.is_open) continue;
    force += glm::dvec3(patch.integral.force_m3);
    volume += static_cast<double>(patch.node.area_m2 * patch.integral.mean_m);
    all.bias_m3 += static_cast<double>(patch.bias_m3);
    variance += static_cast<double>(patch.variance_m6);
  }
  all.deviation_m3 = std::sqrt(variance);
  constexpr double kOfVolume = 0.01;
  all.force_m3 = std::max(glm::length(force), kOfVolume * volume);
  return all;
}

double SurfaceIntegral::WantedOf(const Estimate& all, double accuracy) const {
  return std::max(accuracy * all.force_m3, kNegligible_m * S_.area_m2);
}

// Shares of the error  sum b_i + sqrt(sum v_i)  that add up to it:  b_i + v_i / sqrt(sum v).
double SurfaceIntegral::ShareOf(const Patch& patch, const Estimate& all) {
  const double spread = all.deviation_m3 > 0.0 ? static_cast<double>(patch.variance_m6) / all.deviation_m3 : 0.0;
  return static_cast<double>(patch.bias_m3) + spread;
}

// The largest shares are refined, as few as are enough if each loses kGain of itself. Shares are sorted into bins half
// an octave wide below the whole error.
double SurfaceIntegral::LeastShareToRefine(const Estimate& all, double wanted_m3) const {
  constexpr int kBins = 64;
  constexpr double kPerOctave = 2.0;
  std::array<double, kBins> bins{};
  for (const Patch& patch : front_) {
    if (patch.is_open) continue;
    const double share = ShareOf(patch, all);
    if (!(share > 0.0)) continue;
    const double below = kPerOctave * std::log2(all.error_m3() / share);
    bins[static_cast<std::size_t>(std::clamp(below, 0.0, kBins - 1.0))] += share;
  }
  double left = all.error_m3();
  int bin = 0;
  while (bin < kBins - 1 && left > wanted_m3) left -= kGain * bins[static_cast<std::size_t>(bin++)];
  return all.error_m3() * std::exp2(-bin / kPerOctave);
}

SurfaceIntegral::Result SurfaceIntegral::Run(const core::Pose& X_GS, double accuracy) {
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 e(0.0);
    e[axis] = 1.0;
    R_GS_[axis] = glm::vec3(X_GS.rotate(e));
  }
  voxel_m_ = static_cast<float>(G_.voxel_size_m);
  per_voxel_ = static_cast<float>(1.0 / G_.voxel_size_m);
  origin_ = glm::vec3((X_GS.translation - G_.origin_m) / G_.voxel_size_m);
  result_ = {};
  front_.clear();
  for (std::uint32_t i = 0; i < S_.num_roots; ++i) {
    Patch root;
    root.node = S_.nodes[i];
    if (root.node.num_children == 0) root.triangle = S_.triangles[root.node.first];
    Read(&root);
    Offer(root);
  }
  Estimate all;
  for (int round = 0; round < kMostRounds; ++round) {
    all = EstimateAll();
    const double wanted_m3 = WantedOf(all, accuracy);
    if (all.error_m3() <= wanted_m3) break;
    const double least = LeastShareToRefine(all, wanted_m3);
    const std::size_t count = front_.size();
    for (std::size_t i = 0; i < count && front_.size() < kMostPatches; ++i) {
      Patch& patch = front_[i];
      if (patch.is_open || ShareOf(patch, all) <= least) continue;
      // The field's part of its share, where the patch is small enough for one exact place to stand for it.
      const double by_field = static_cast<double>(patch.field_bias_m3) +
                              static_cast<double>(patch.field_variance_m6) / std::max(all.deviation_m3, 1e-300);
      constexpr double kMostly = 0.5;
      if (!patch.is_exact && patch.node.radius_m < voxel_m_ && by_field > kMostly * ShareOf(patch, all)) {
        patch.is_exact = true;
        ReadTriangles(&patch);
        Integrate(&patch);
      } else {
        Open(i);
      }
    }
    if (front_.size() >= kMostPatches) break;
  }
  for (const Patch& patch : front_) {
    if (patch.is_open) continue;
    const glm::dvec3 force(patch.integral.force_m3);
    result_.force_m3 += force;
    result_.moment_m4 += glm::cross(glm::dvec3(patch.node.centre_m), force) + glm::dvec3(patch.integral.moment_m4);
    result_.volume_m3 += static_cast<double>(patch.node.area_m2 * patch.integral.mean_m);
    result_.square_m4 += static_cast<double>(patch.node.area_m2 * patch.integral.mean_square_m2);
    result_.deepest_m = std::max(result_.deepest_m, static_cast<double>(patch.depth_m));
    result_.patches_inside += patch.depth_m > 0.0f ? 1 : 0;
  }
  all = EstimateAll();
  result_.error_m3 = all.error_m3();
  result_.is_accurate = all.error_m3() <= WantedOf(all, accuracy);
  return result_;
}

}  // namespace vps
