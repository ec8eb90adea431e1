#include <cmath>
#include <queue>

#include "tools/contact/methods/apart_bound.hpp"
#include "tools/contact/methods/method.hpp"
#include "vps/surface/surface_walk.hpp"

namespace contact {

struct SurfacePair {
  SurfacePair(Cooked field, vps::SurfaceTree surface)
      : cooked(std::move(field)), B(std::move(surface)), bends(vps::BuildFieldBends(*cooked->field)) {}

  Cooked cooked;
  vps::SurfaceTree B;
  vps::FieldBends bends;
};

namespace {

// A part of B with a lower bound of its distance from A.
struct NearPart {
  double bound_m = 0.0;
  vps::SurfaceNode node;
  vps::SurfacePiece triangle;  // of a leaf

  // std::priority_queue takes the greatest: the nearest part.
  bool operator<(const NearPart& other) const { return bound_m > other.bound_m; }
};

class SurfaceMethod : public Method {
 public:
  SurfaceMethod(std::shared_ptr<const SurfacePair> pair, double accuracy, bool bounds_distance)
      : pair_(std::move(pair)),
        A_(*pair_->cooked->field),
        B_(pair_->B),
        accuracy_(accuracy),
        bounds_distance_(bounds_distance) {}

  Answer Query(const core::Pose& X_AB) override {
    const vps::SurfaceWalk::Result& result = walk_.Run(B_, A_, pair_->bends, X_AB, {.accuracy = accuracy_});
    Answer answer;
    answer.points_tested = result.places_read;
    answer.force_error = result.error_m3;
    answer.is_accurate = result.is_accurate;
    answer.contacts = result.patches_inside;
    answer.force_A = X_AB.rotate(result.force_m3);
    answer.moment_A = X_AB.rotate(result.moment_m4);
    if (answer.contacts > 0) {
      answer.signed_distance_m = -result.deepest_m;
    } else if (bounds_distance_) {
      answer.signed_distance_m = ApartBound_m(X_AB);
    }
    return answer;
  }

 private:
  // By branch and bound, nearest first. A place of a node is within its radius of its centre, and distances are
  // 1-Lipschitz. Ends where the nearest part is small against its distance, or after kMostParts, with what is proven
  // by then (not derived: a millisecond).
  [[nodiscard]] double ApartBound_m(const core::Pose& X_AB) const {
    constexpr int kMostParts = 20'000;
    constexpr double kTolerance = 0.02;
    std::priority_queue<NearPart> parts;
    const auto offer = [&](const vps::SurfaceNode& node, const vps::SurfacePiece& triangle) {
      const glm::vec3 p((X_AB * glm::dvec3(node.centre_m) - A_.origin_m) / A_.voxel_size_m);
      const double distance_m = static_cast<double>(LowerBoundOfDistance(A_, p)) * A_.voxel_size_m;
      parts.push({distance_m - static_cast<double>(node.radius_m), node, triangle});
    };
    const auto offer_node = [&](std::uint32_t i) {
      const vps::SurfaceNode& node = B_.nodes[i];
      offer(node, node.num_children == 0 ? B_.triangles[node.first] : vps::SurfacePiece{});
    };
    for (std::uint32_t i = 0; i < B_.num_roots; ++i) offer_node(i);
    for (int n = 0; n < kMostParts; ++n) {
      const NearPart nearest = parts.top();
      const auto radius_m = static_cast<double>(nearest.node.radius_m);
      if (radius_m < kTolerance * (nearest.bound_m + radius_m)) break;
      parts.pop();
      if (nearest.node.num_children > 0) {
        for (std::uint32_t i = 0; i < nearest.node.num_children; ++i) offer_node(nearest.node.first + i);
        continue;
      }
      const auto& [a, b, c] = nearest.triangle.corners;
      const glm::vec3 ab = 0.5f * (a + b);
      const glm::vec3 bc = 0.5f * (b + c);
      const glm::vec3 ca = 0.5f * (c + a);
      for (const vps::SurfacePiece& part : {vps::SurfacePiece{{a, ab, ca}}, vps::SurfacePiece{{ab, b, bc}},
                                            vps::SurfacePiece{{ca, bc, c}}, vps::SurfacePiece{{bc, ca, ab}}}) {
        offer(vps::NodeOf(part), part);
      }
    }
    return std::max(0.0, parts.top().bound_m);
  }

  std::shared_ptr<const SurfacePair> pair_;
  const vps::DistanceField& A_;
  const vps::SurfaceTree& B_;
  vps::SurfaceWalk walk_;
  double accuracy_;
  bool bounds_distance_;
};

}  // namespace

core::Result<std::shared_ptr<const SurfacePair>> MakeSurfacePair(Cooked A, const vps::TriangleMesh& B,
                                                                 std::uint32_t num_points) {
  // As SurfacePieces of cooked parts are cut.
  constexpr double kSpacings = 4.0;
  const double area_m2 = vps::SurfaceArea_m2(B);
  if (area_m2 <= 0.0) return core::Fail(core::ErrorCode::kInvalidInput, "B: no triangle with an area");
  const double longest_m = kSpacings * std::sqrt(area_m2 / num_points);
  return std::make_shared<const SurfacePair>(std::move(A), vps::BuildSurfaceTree(B, longest_m));
}

std::unique_ptr<Method> MakeSurfaceMethod(std::shared_ptr<const SurfacePair> pair, double accuracy) {
  return std::make_unique<SurfaceMethod>(std::move(pair), accuracy, false);
}

core::Result<std::unique_ptr<Method>> MakeSurfaceMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                        const Resolution& resolution, double accuracy) {
  const Resolution resolved = ResolveResolution(A, B, resolution);
  auto cooked = vps::Cook(A, {resolved.voxel_size_m, 0, vps::Method::kFast});
  if (!cooked) return core::Fail(cooked.error().code, "A: " + cooked.error().detail);
  auto pair = MakeSurfacePair(std::make_shared<const vps::CookedObject>(std::move(*cooked)), B, resolved.num_points);
  if (!pair) return tl::unexpected(pair.error());
  return std::make_unique<SurfaceMethod>(std::move(*pair), accuracy, true);
}

}  // namespace contact
