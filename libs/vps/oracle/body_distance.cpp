#include "vps/oracle/body_distance.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace vps::oracle {
namespace {

glm::dvec3 Centroid(const Triangle& t) {
  return (t[0] + t[1] + t[2]) / 3.0;
}

double Radius(const Triangle& t, const glm::dvec3& c) {
  return std::max({glm::distance(c, t[0]), glm::distance(c, t[1]), glm::distance(c, t[2])});
}

Triangle Move(const core::Pose& X, const Triangle& t) {
  return {X * t[0], X * t[1], X * t[2]};
}

class SurfaceSearch {
 public:
  SurfaceSearch(const MeshDistance& A, const MeshDistance& B, const core::Pose& X_AB) : A_(A), B_(B), X_AB_(X_AB) {}

  double Run(glm::dvec3* p_A_m) {
    Descend(0, 0);
    if (p_A_m != nullptr) *p_A_m = point_;
    return best_;
  }

 private:
  // Distance of a box of A and a sphere of B.
  double Bound(std::uint32_t a, std::uint32_t b) const {
    const MeshDistance::Node& box = A_.nodes()[a];
    const MeshDistance::Node& ball = B_.nodes()[b];
    const glm::dvec3 c = X_AB_ * ball.centre_m;
    const glm::dvec3 gap = glm::max(glm::max(box.lower_m - c, c - box.upper_m), glm::dvec3(0.0));
    return glm::length(gap) - ball.radius_m;
  }

  void Descend(std::uint32_t a, std::uint32_t b) {
    if (best_ <= 0.0 || Bound(a, b) >= best_) return;
    const MeshDistance::Node& na = A_.nodes()[a];
    const MeshDistance::Node& nb = B_.nodes()[b];
    if (na.left == 0 && nb.left == 0) {
      for (std::uint32_t j = nb.first; j < nb.first + nb.count; ++j) {
        const Triangle t = Move(X_AB_, B_.triangles()[j]);
        for (std::uint32_t i = na.first; i < na.first + na.count; ++i) {
          const double distance = TriangleDistance(A_.triangles()[i], t);
          if (distance < best_) {
            best_ = distance;
            point_ = Centroid(t);
          }
        }
      }
      return;
    }
    const bool split_a = nb.left == 0 || (na.left != 0 && na.radius_m >= nb.radius_m);
    const std::uint32_t left = split_a ? na.left : nb.left;
    const double first = split_a ? Bound(left, b) : Bound(a, left);
    const double second = split_a ? Bound(left + 1, b) : Bound(a, left + 1);
    const std::uint32_t near = first <= second ? left : left + 1;
    const std::uint32_t far = first <= second ? left + 1 : left;
    split_a ? Descend(near, b) : Descend(a, near);
    split_a ? Descend(far, b) : Descend(a, far);
  }

  const MeshDistance& A_;
  const MeshDistance& B_;
  const core::Pose X_AB_;
  double best_ = std::numeric_limits<double>::infinity();
  glm::dvec3 point_{0.0};
};

// A group of B's triangles (node >= 0) or one piece of a triangle, with an upper bound of the depth in it.
struct Region {
  double bound = 0.0;
  std::int64_t node = -1;
  Triangle t{};
  std::uint64_t order = 0;  // ties are broken by age, not by address
  bool operator<(const Region& other) const { return bound != other.bound ? bound < other.bound : order > other.order; }
};

class DeepestSearch {
 public:
  DeepestSearch(const MeshDistance& A, const MeshDistance& B, const core::Pose& X_AB) : A_(A), B_(B), X_AB_(X_AB) {}

  Deepest Run() {
    constexpr std::uint64_t kMaxRegions = 50'000;  // not derived; what is left is in error_bound_m
    if (B_.triangles().empty()) return {};
    tolerance_ = 1e-9 * B_.nodes()[0].radius_m;
    PushNode(0);
    while (!open_.empty()) {
      const Region region = open_.top();
      const double goal = std::max(tolerance_, 1e-3 * best_.depth_m);
      best_.error_bound_m = std::max(0.0, region.bound - best_.depth_m);
      if (best_.error_bound_m <= goal || num_regions_ >= kMaxRegions) break;
      open_.pop();
      if (region.node >= 0) {
        const MeshDistance::Node& node = B_.nodes()[static_cast<std::size_t>(region.node)];
        if (node.left != 0) {
          PushNode(node.left);
          PushNode(node.left + 1);
        } else {
          for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
            PushPiece(Move(X_AB_, B_.triangles()[i]));
        }
      } else {
        const Triangle& t = region.t;
        const glm::dvec3 a = 0.5 * (t[1] + t[2]);
        const glm::dvec3 b = 0.5 * (t[2] + t[0]);
        const glm::dvec3 c = 0.5 * (t[0] + t[1]);
        PushPiece({t[0], c, b});
        PushPiece({c, t[1], a});
        PushPiece({b, a, t[2]});
        PushPiece({a, b, c});
      }
    }
    if (open_.empty()) best_.error_bound_m = 0.0;
    return best_;
  }

 private:
  double Try(const glm::dvec3& x) {
    const double d = A_.SignedDistance(x);
    if (-d > best_.depth_m) {
      best_.depth_m = -d;
      best_.p_A_m = x;
    }
    return d;
  }

  // Depth changes no faster than the point moves: depth <= depth(centre) + radius.
  void PushNode(std::uint32_t index) {
    const MeshDistance::Node& node = B_.nodes()[index];
    // The centre need not be on the surface: no candidate.
    Push({node.radius_m - A_.SignedDistance(X_AB_ * node.centre_m), index, {}, 0});
  }

  // Another bound of the depth is the distance to any one triangle of A, which is convex: its maximum over the piece is
  // at a corner. For parallel flat faces this bound is sharp at once.
  void PushPiece(const Triangle& t) {
    const glm::dvec3 c = Centroid(t);
    double bound = Radius(t, c) - Try(c);
    const auto consider = [&](const glm::dvec3& x) {
      const auto nearest = A_.FindNearest(x);
      if (!nearest) return;
      const Triangle& wall = A_.triangles()[nearest->triangle];
      double farthest = 0.0;
      for (const glm::dvec3& v : t) farthest = std::max(farthest, glm::distance(v, NearestPointOnTriangle(v, wall)));
      bound = std::min(bound, farthest);
    };
    if (bound > best_.depth_m) {
      consider(c);
      for (const glm::dvec3& v : t) {
        Try(v);
        consider(v);
      }
    }
    Push({bound, -1, t, 0});
  }

  void Push(Region region) {
    ++num_regions_;
    region.order = num_regions_;
    if (region.bound > best_.depth_m + tolerance_) open_.push(region);
  }

  const MeshDistance& A_;
  const MeshDistance& B_;
  const core::Pose X_AB_;
  double tolerance_ = 0.0;
  std::uint64_t num_regions_ = 0;
  std::priority_queue<Region> open_;
  Deepest best_;
};

}  // namespace

double SurfaceDistance(const MeshDistance& A, const MeshDistance& B, const core::Pose& X_AB, glm::dvec3* p_A_m) {
  if (A.triangles().empty() || B.triangles().empty()) return std::numeric_limits<double>::infinity();
  return SurfaceSearch(A, B, X_AB).Run(p_A_m);
}

Deepest FindDeepest(const MeshDistance& A, const MeshDistance& B, const core::Pose& X_AB) {
  return DeepestSearch(A, B, X_AB).Run();
}

BodyDistance SignedBodyDistance(const MeshDistance& A, const MeshDistance& B, const core::Pose& X_AB) {
  BodyDistance result;
  const core::Pose X_BA = X_AB.inverse();
  result.signed_distance_m = SurfaceDistance(A, B, X_AB, &result.p_A_m);
  if (result.signed_distance_m > 0.0) {
    // No surface crosses the other: a part is wholly inside or outside.
    bool is_apart = true;
    for (const glm::dvec3& p : B.part_corners()) is_apart = is_apart && A.SignedDistance(X_AB * p) > 0.0;
    for (const glm::dvec3& p : A.part_corners()) is_apart = is_apart && B.SignedDistance(X_BA * p) > 0.0;
    if (is_apart) return result;
  }
  const Deepest in_A = FindDeepest(A, B, X_AB);
  const Deepest in_B = FindDeepest(B, A, X_BA);
  if (in_A.depth_m > 0.0 || in_B.depth_m > 0.0) {
    result.is_deepest_in_A = in_A.depth_m >= in_B.depth_m;
    result.signed_distance_m = -std::max(in_A.depth_m, in_B.depth_m);
    result.p_A_m = result.is_deepest_in_A ? in_A.p_A_m : X_AB * in_B.p_A_m;
    const double bound = std::max(in_A.depth_m + in_A.error_bound_m, in_B.depth_m + in_B.error_bound_m);
    result.error_bound_m = bound + result.signed_distance_m;
  }
  return result;
}

}  // namespace vps::oracle
