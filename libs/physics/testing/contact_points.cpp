#include "physics/testing/contact_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace physics {
namespace {

constexpr int kMaxGroups = 4;
constexpr int kNodesPerGroup = static_cast<int>(core::kMaxContactPlanes) / kMaxGroups;
// Normals within 20 degrees (cos 20 = 0.94) form one group. Chosen, no study: larger merges faces whose forces then
// lose their moments about the mean normal, smaller runs out of groups on curved contact.
constexpr double kSameDirection = 0.94;
// A narrower group is a line or a point. Far above the rounding of a position sent as float (1e-8 m at 0.1 m), far
// below any face.
constexpr double kLeastExtent_m = 1e-6;
// Largest correlation of u and v at which tangents stay as they are. Chosen, no study: turning to the principal axes
// removes the covariance, which the nodes cannot represent; keeping the axes keeps the planes' ids for warm starting.
constexpr double kCorrelated = 0.1;

double Force_N(const ContactPoint& point) {
  return point.stiffness_N_per_m * std::max(0.0, -point.gap_m);
}

using Directions = core::FixedVector<glm::dvec3, kMaxGroups>;

int GroupOf(const Directions& directions_W, const glm::dvec3& n_W) {
  int best = 0;
  for (std::size_t i = 1; i < directions_W.size(); ++i) {
    if (glm::dot(directions_W[i], n_W) > glm::dot(directions_W[static_cast<std::size_t>(best)], n_W)) {
      best = static_cast<int>(i);
    }
  }
  return best;
}

// Normals of the point with the largest force, then of the largest with another direction, and so on; without any
// force the nearest points count.
Directions ChooseDirections(std::span<const ContactPoint> points) {
  Directions directions_W;
  while (directions_W.size() < kMaxGroups) {
    const ContactPoint* best = nullptr;
    for (const ContactPoint& point : points) {
      const bool is_known = std::any_of(directions_W.begin(), directions_W.end(),
                                        [&](const glm::dvec3& d) { return glm::dot(d, point.n_W) > kSameDirection; });
      if (is_known) continue;
      if (best == nullptr || Force_N(point) > Force_N(*best) ||
          (Force_N(point) == Force_N(*best) && point.gap_m < best->gap_m)) {
        best = &point;
      }
    }
    if (best == nullptr) break;
    directions_W.push_back(best->n_W);
  }
  return directions_W;
}

struct Axes {
  glm::dvec3 n, u, v;
};

// Tangents that depend on the normal alone, not on the points: from the smallest of its components in G.
Axes TangentsOf(const glm::dvec3& n_W, const core::Pose& X_WG) {
  const glm::dvec3 n_G = glm::conjugate(X_WG.rotation) * n_W;
  int least = 0;
  for (int c = 1; c < 3; ++c) {
    if (std::abs(n_G[c]) < std::abs(n_G[least]) - 1e-3) least = c;
  }
  glm::dvec3 e(0.0);
  e[least] = 1.0;
  const glm::dvec3 u = glm::normalize(glm::cross(e, n_G));
  return {n_W, X_WG.rotate(u), X_WG.rotate(glm::cross(n_G, u))};
}

// Weighted moments of points in the tangent plane.
struct Spread {
  double weight = 0.0;
  glm::dvec3 mean_W{0.0};
  double var_u = 0.0, var_v = 0.0, cov = 0.0;
  double lo_u = 0.0, hi_u = 0.0, lo_v = 0.0, hi_v = 0.0;  // from the mean
};

struct Group {
  int index = 0;
  std::span<const ContactPoint> points;
  const Directions* directions_W = nullptr;
  bool pushes = false;

  // visit(point) for its points: those that push, or all when none does.
  template <typename Visit>
  void ForEach(Visit&& visit) const {
    for (const ContactPoint& point : points) {
      if (pushes && !(point.gap_m < 0.0)) continue;
      if (GroupOf(*directions_W, point.n_W) == index) visit(point);
    }
  }
};

template <typename Weight>
Spread Measure(const Group& group, Axes* axes, Weight&& weight) {
  Spread s;
  group.ForEach([&](const ContactPoint& p) {
    s.weight += weight(p);
    s.mean_W += weight(p) * p.p_W;
  });
  if (!(s.weight > 0.0)) return s;
  s.mean_W /= s.weight;
  const auto spread = [&] {
    s.var_u = s.var_v = s.cov = s.lo_u = s.hi_u = s.lo_v = s.hi_v = 0.0;
    group.ForEach([&](const ContactPoint& p) {
      const double u = glm::dot(axes->u, p.p_W - s.mean_W);
      const double v = glm::dot(axes->v, p.p_W - s.mean_W);
      s.var_u += weight(p) * u * u;
      s.var_v += weight(p) * v * v;
      s.cov += weight(p) * u * v;
      s.lo_u = std::min(s.lo_u, u);
      s.hi_u = std::max(s.hi_u, u);
      s.lo_v = std::min(s.lo_v, v);
      s.hi_v = std::max(s.hi_v, v);
    });
    s.var_u /= s.weight;
    s.var_v /= s.weight;
    s.cov /= s.weight;
  };
  spread();
  if (s.cov * s.cov > kCorrelated * kCorrelated * s.var_u * s.var_v) {
    // Turn to the principal axes: tan(2 angle) = 2 cov / (var_u - var_v).
    const double angle = 0.5 * std::atan2(2.0 * s.cov, s.var_u - s.var_v);
    const glm::dvec3 u = std::cos(angle) * axes->u + std::sin(angle) * axes->v;
    axes->v = glm::cross(axes->n, u);
    axes->u = u;
    spread();
  }
  return s;
}

struct Node {
  double u = 0.0, v = 0.0;
  double share = 0.0;  // of the weight
};

using Nodes = core::FixedVector<Node, kNodesPerGroup>;

Nodes PlaceNodes(const Spread& s) {
  Nodes nodes;
  const bool is_wide_u = s.hi_u > kLeastExtent_m && -s.lo_u > kLeastExtent_m && s.var_u > 0.0;
  const bool is_wide_v = s.hi_v > kLeastExtent_m && -s.lo_v > kLeastExtent_m && s.var_v > 0.0;
  const double rest =
      1.0 - (is_wide_u ? s.var_u / (-s.lo_u * s.hi_u) : 0.0) - (is_wide_v ? s.var_v / (-s.lo_v * s.hi_v) : 0.0);
  if (rest >= 0.0) {
    if (is_wide_u) {
      nodes.push_back({s.lo_u, 0.0, s.var_u / (-s.lo_u * (s.hi_u - s.lo_u))});
      nodes.push_back({s.hi_u, 0.0, s.var_u / (s.hi_u * (s.hi_u - s.lo_u))});
    }
    if (is_wide_v) {
      nodes.push_back({0.0, s.lo_v, s.var_v / (-s.lo_v * (s.hi_v - s.lo_v))});
      nodes.push_back({0.0, s.hi_v, s.var_v / (s.hi_v * (s.hi_v - s.lo_v))});
    }
    if (rest > 1e-9) nodes.push_back({0.0, 0.0, rest});
    return nodes;
  }
  struct Two {
    double at[2], share[2];
  };
  const auto two = [](double variance, double lo, double hi) {
    const double q = std::sqrt(-lo / hi);
    const double sigma = std::sqrt(variance);
    const double a = -sigma * q;
    const double b = sigma / q;
    return Two{{a, b}, {b / (b - a), -a / (b - a)}};
  };
  const Two one{{0.0, 0.0}, {1.0, 0.0}};
  const Two along_u = is_wide_u ? two(s.var_u, s.lo_u, s.hi_u) : one;
  const Two along_v = is_wide_v ? two(s.var_v, s.lo_v, s.hi_v) : one;
  for (int i = 0; i < (is_wide_u ? 2 : 1); ++i) {
    for (int j = 0; j < (is_wide_v ? 2 : 1); ++j) {
      nodes.push_back({along_u.at[i], along_v.at[j], along_u.share[i] * along_v.share[j]});
    }
  }
  return nodes;
}

// Direction of a normal in G as one of 27 cells of a cube.
std::uint32_t DirectionOf(const glm::dvec3& n_G) {
  std::uint32_t cell = 0;
  for (int c = 0; c < 3; ++c) cell = 3 * cell + (n_G[c] > 0.4 ? 2u : n_G[c] < -0.4 ? 0u : 1u);
  return cell;
}

// Depths of the nodes: d0 + a u + b v. With the nodes' moments K, K var_u, K var_v the sums over the nodes are F = K d0
// along n and, about the mean, T = -(K var_u a) v + (K var_v b) u: those of the points.
struct DepthLine {
  double d0 = 0.0, a = 0.0, b = 0.0;
  [[nodiscard]] double At(const Node& node) const { return d0 + a * node.u + b * node.v; }
};

DepthLine FitForces(const Group& group, const Axes& axes, const Spread& s) {
  double force_N = 0.0;
  glm::dvec3 torque_Nm(0.0);
  group.ForEach([&](const ContactPoint& p) {
    const glm::dvec3 force_W = Force_N(p) * p.n_W;
    force_N += glm::dot(axes.n, force_W);
    torque_Nm += glm::cross(p.p_W - s.mean_W, force_W);
  });
  DepthLine line;
  line.d0 = force_N / s.weight;
  if (s.var_u > 0.0) line.a = -glm::dot(torque_Nm, axes.v) / (s.weight * s.var_u);
  if (s.var_v > 0.0) line.b = glm::dot(torque_Nm, axes.u) / (s.weight * s.var_v);
  return line;
}

// Depths of the points (negative: apart) as a line in u and v, by least squares weighted with the stiffness.
DepthLine FitGaps(const Group& group, const Axes& axes, const Spread& s) {
  DepthLine line;
  double sum = 0.0;
  double sum_u = 0.0;
  double sum_v = 0.0;
  group.ForEach([&](const ContactPoint& p) {
    const double weighted = -p.gap_m * p.stiffness_N_per_m;
    sum += weighted;
    sum_u += weighted * glm::dot(axes.u, p.p_W - s.mean_W);
    sum_v += weighted * glm::dot(axes.v, p.p_W - s.mean_W);
  });
  line.d0 = sum / s.weight;
  if (s.var_u > 0.0) line.a = sum_u / (s.weight * s.var_u);
  if (s.var_v > 0.0) line.b = sum_v / (s.weight * s.var_v);
  return line;
}

struct Reduced {
  Axes axes;
  Spread spread;
  Nodes nodes;
  std::array<double, kNodesPerGroup> depth_m{};
  double stiffness_N_per_m = 0.0;
};

Reduced ReducePushing(const Group& group, const Axes& axes) {
  Reduced r{axes, {}, {}, {}, 0.0};
  r.spread = Measure(group, &r.axes, [](const ContactPoint& p) { return p.stiffness_N_per_m; });
  r.stiffness_N_per_m = r.spread.weight;
  r.nodes = PlaceNodes(r.spread);
  DepthLine line = FitForces(group, r.axes, r.spread);
  const bool pulls = std::any_of(r.nodes.begin(), r.nodes.end(), [&](const Node& n) { return line.At(n) < 0.0; });
  if (pulls) {
    r.axes = axes;
    const Axes fixed = axes;
    r.spread = Measure(group, &r.axes, [&fixed](const ContactPoint& p) {
      return Force_N(p) * std::max(0.0, glm::dot(fixed.n, p.n_W));
    });
    r.nodes = PlaceNodes(r.spread);
    line = {r.spread.weight / r.stiffness_N_per_m, 0.0, 0.0};
  }
  for (std::size_t i = 0; i < r.nodes.size(); ++i) r.depth_m[i] = line.At(r.nodes[i]);
  return r;
}

Reduced ReduceApart(const Group& group, const Axes& axes) {
  Reduced r{axes, {}, {}, {}, 0.0};
  r.spread = Measure(group, &r.axes, [](const ContactPoint& p) { return p.stiffness_N_per_m; });
  if (!(r.spread.weight > 0.0)) return r;
  r.stiffness_N_per_m = r.spread.weight;
  r.nodes = PlaceNodes(r.spread);
  const DepthLine line = FitGaps(group, r.axes, r.spread);
  double nearest = -1e9;
  group.ForEach([&](const ContactPoint& p) { nearest = std::max(nearest, -p.gap_m); });
  for (std::size_t i = 0; i < r.nodes.size(); ++i) r.depth_m[i] = std::min(line.At(r.nodes[i]), nearest);
  return r;
}

}  // namespace

void ReduceContactPoints(std::span<const ContactPoint> points, const core::Pose& X_WS, const core::Pose& X_WG,
                         core::FixedVector<core::ContactPlane, core::kMaxContactPlanes>* planes) {
  planes->clear();
  const Directions directions_W = ChooseDirections(points);
  const core::Pose X_SW = X_WS.inverse();
  const core::Pose X_GW = X_WG.inverse();
  for (std::size_t g = 0; g < directions_W.size(); ++g) {
    Group group{static_cast<int>(g), points, &directions_W, false};
    glm::dvec3 force_W(0.0);
    group.ForEach([&](const ContactPoint& p) { force_W += Force_N(p) * p.n_W; });
    group.pushes = glm::length(force_W) > 0.0;
    const Axes axes = TangentsOf(group.pushes ? glm::normalize(force_W) : directions_W[g], X_WG);
    const Reduced r = group.pushes ? ReducePushing(group, axes) : ReduceApart(group, axes);
    std::uint32_t id = 8 * DirectionOf(X_GW.rotate(r.axes.n));
    while (std::any_of(planes->begin(), planes->end(),
                       [id](const core::ContactPlane& plane) { return plane.id / 8 == id / 8; })) {
      id += 8 * 27;  // a second group in the same direction
    }
    for (std::size_t i = 0; i < r.nodes.size(); ++i) {
      const Node& node = r.nodes[i];
      const glm::dvec3 p_W = r.spread.mean_W + node.u * r.axes.u + node.v * r.axes.v;
      core::ContactPlane plane;
      plane.id = id + static_cast<std::uint32_t>(i);
      plane.p_S = glm::vec3(X_SW * p_W);
      // gap = n . (p - q) with the floats that are sent: to 1e-9 m at 0.1 m.
      plane.q_G = glm::vec3(X_GW * (p_W + r.depth_m[i] * r.axes.n));
      plane.n_G = glm::vec3(X_GW.rotate(r.axes.n));
      plane.stiffness_N_per_m = static_cast<float>(node.share * r.stiffness_N_per_m);
      planes->push_back(plane);
    }
  }
}

}  // namespace physics
