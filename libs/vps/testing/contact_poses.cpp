#include "vps/testing/contact_poses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "vps/oracle/body_distance.hpp"
#include "vps/oracle/first_touch.hpp"

namespace vps {
namespace {

// Not derived: how often a pose is drawn anew that nothing allows.
constexpr int kMostTries = 40;

double LogUniform(double low, double high, CaseRandom* random) {
  return std::pow(10.0, random->Uniform(std::log10(low), std::log10(high)));
}

double LongestSide(const Box& box) {
  const glm::dvec3 size = box.upper - box.lower;
  return std::max({size.x, size.y, size.z});
}

glm::dvec3 AnyPerpendicular(const glm::dvec3& unit, CaseRandom* random) {
  while (true) {
    const glm::dvec3 v = glm::cross(unit, random->Direction());
    if (glm::length(v) > 0.1) return glm::normalize(v);
  }
}

// A place on a surface with its outward normal, and a direction in it.
struct Place {
  glm::dvec3 p_m{0.0};
  glm::dvec3 outward{0.0};
  glm::dvec3 along{0.0};

  [[nodiscard]] glm::dmat3 frame() const { return {along, glm::cross(outward, along), outward}; }
};

// A part's faces and sharp edges, drawn with a chance in proportion to area and length.
class Places {
 public:
  explicit Places(const TriangleMesh& mesh) : mesh_(mesh) {
    // Where planes meet at less than this an edge is a facet's border rather than sharp; not derived further.
    const double least_turn = std::cos(30.0 * 3.14159265358979 / 180.0);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> sides;
    double area = 0.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      areas_.push_back(area += glm::length(Normal(t)));
      for (int k = 0; k < 3; ++k) sides[{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}] = t;
    }
    double length = 0.0;
    for (const auto& [edge, t] : sides) {
      const auto other = sides.find({edge.second, edge.first});
      if (edge.first > edge.second || other == sides.end()) continue;
      const glm::dvec3 a = Normal(t);
      const glm::dvec3 b = Normal(other->second);
      if (!(glm::dot(a, b) < least_turn * glm::length(a) * glm::length(b))) continue;
      const glm::dvec3 along = mesh.vertices[edge.second] - mesh.vertices[edge.first];
      // Seen along the edge, the triangle that has it in its own direction lies on the left. Convex: its normal turns
      // to the other's about the edge.
      if (!(glm::dot(glm::cross(a, b), along) > 0.0)) continue;
      edges_.push_back({mesh.vertices[edge.first], mesh.vertices[edge.second],
                        glm::normalize(glm::normalize(a) + glm::normalize(b))});
      lengths_.push_back(length += glm::length(along));
    }
  }

  [[nodiscard]] Place DrawFace(CaseRandom* random) const {
    const std::size_t t = Draw(areas_, random);
    const std::array<glm::dvec3, 3> c = mesh_.corners(t);
    double u = random->Uniform(0.0, 1.0);
    double v = random->Uniform(0.0, 1.0);
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    const glm::dvec3 outward = glm::normalize(Normal(t));
    return {c[0] + u * (c[1] - c[0]) + v * (c[2] - c[0]), outward, AnyPerpendicular(outward, random)};
  }

  // Its outward normal is the mean of its two faces'.
  [[nodiscard]] std::optional<Place> DrawEdge(CaseRandom* random) const {
    if (edges_.empty()) return std::nullopt;
    const Edge& edge = edges_[Draw(lengths_, random)];
    return Place{glm::mix(edge.from_m, edge.to_m, random->Uniform(0.0, 1.0)), edge.outward,
                 glm::normalize(edge.to_m - edge.from_m)};
  }

 private:
  struct Edge {
    glm::dvec3 from_m{0.0}, to_m{0.0}, outward{0.0};
  };

  [[nodiscard]] glm::dvec3 Normal(std::size_t t) const {
    const std::array<glm::dvec3, 3> c = mesh_.corners(t);
    return glm::cross(c[1] - c[0], c[2] - c[0]);
  }

  static std::size_t Draw(const std::vector<double>& sums, CaseRandom* random) {
    const double at = random->Uniform(0.0, sums.back());
    const auto found = std::upper_bound(sums.begin(), sums.end(), at);
    return std::min<std::size_t>(static_cast<std::size_t>(found - sums.begin()), sums.size() - 1);
  }

  const TriangleMesh& mesh_;
  std::vector<double> areas_, lengths_;  // summed
  std::vector<Edge> edges_;
};

// B's place comes to A's, `depth_m` beyond it, normals opposed. The directions in the surfaces enclose a random angle.
core::Pose Join(const Place& at_A, const Place& at_B, double depth_m) {
  const glm::dmat3 turned(at_A.along, glm::cross(-at_A.outward, at_A.along), -at_A.outward);
  core::Pose X_AB;
  X_AB.rotation = glm::normalize(glm::quat_cast(turned * glm::transpose(at_B.frame())));
  X_AB.translation = at_A.p_m - depth_m * at_A.outward - X_AB.rotation * at_B.p_m;
  return X_AB;
}

class Poser {
 public:
  Poser(const TriangleMesh& A, const TriangleMesh& B, CaseRandom* random)
      : random_(*random), A_(A), B_(B), box_A_(BoundingBox(A)), box_B_(BoundingBox(B)), places_A_(A), places_B_(B) {
    size_m_ = std::min(LongestSide(box_A_), LongestSide(box_B_));
    points_A_m_ = DrawPoints(A, places_A_);
    points_B_m_ = DrawPoints(B, places_B_);
  }

  std::vector<ContactPose> Run(int count_each) {
    for (int i = 0; i < count_each; ++i) Approach(PoseKind::kLight, LogUniform(1e-5, 1e-3, &random_));
    for (int i = 0; i < count_each; ++i) Approach(PoseKind::kMedium, LogUniform(1e-3, 1e-2, &random_));
    for (int i = 0; i < count_each; ++i) Approach(PoseKind::kDeep, random_.Uniform(2e-2, 1e-1));
    Slide(count_each);
    for (int i = 0; i < count_each; ++i) LayFlat(i % 2 == 1);
    for (int i = 0; i < count_each; ++i) LayEdge(i % 2 == 1);
    return poses_;
  }

 private:
  std::optional<oracle::FirstTouch> Touch() {
    for (int k = 0; k < kMostTries; ++k) {
      const glm::dvec3 from = random_.Direction();
      if (auto touch = oracle::FindFirstTouch(A_, box_A_, B_, box_B_, random_.Rotation(), from)) return touch;
    }
    return std::nullopt;
  }

  void Approach(PoseKind kind, double depth) {
    if (const auto touch = Touch()) poses_.push_back({kind, touch->Beyond(depth * size_m_)});
  }

  void Slide(int count) {
    const auto touch = Touch();
    if (!touch) return;
    core::Pose X_AB = touch->Beyond(LogUniform(1e-4, 1e-3, &random_) * size_m_);
    const glm::dvec3 along = AnyPerpendicular(touch->from_A, &random_);
    for (int i = 0; i < count; ++i) {
      poses_.push_back({PoseKind::kSliding, X_AB});
      X_AB.translation += 1e-3 * size_m_ * along;
    }
  }

  void LayFlat(bool is_tilted) {
    for (int k = 0; k < kMostTries; ++k) {
      const double depth_m = LogUniform(1e-5, 1e-3, &random_) * size_m_;
      const double tilt = is_tilted ? LogUniform(1e-4, 1e-2, &random_) : 0.0;
      const Place at_A = places_A_.DrawFace(&random_);
      Place at_B = places_B_.DrawFace(&random_);
      const glm::dquat turn = core::QuaternionFromRotationVector(tilt * AnyPerpendicular(at_B.outward, &random_));
      at_B.outward = turn * at_B.outward;
      at_B.along = turn * at_B.along;
      // A tilted face is deeper by up to the size times the tilt.
      if (Keep(PoseKind::kFlat, Join(at_A, at_B, depth_m), depth_m + tilt * size_m_)) return;
    }
  }

  void LayEdge(bool is_A) {
    for (int k = 0; k < kMostTries; ++k) {
      const double depth_m = LogUniform(1e-4, 1e-3, &random_) * size_m_;
      const auto edge = (is_A ? places_A_ : places_B_).DrawEdge(&random_);
      if (!edge) return;
      const Place face = (is_A ? places_B_ : places_A_).DrawFace(&random_);
      const core::Pose X_AB = is_A ? Join(face, *edge, depth_m).inverse() : Join(face, *edge, depth_m);
      if (Keep(PoseKind::kEdge, X_AB, depth_m)) return;
    }
  }

  // Unless something else is in the way and more than three times as deep as meant (not derived).
  bool Keep(PoseKind kind, const core::Pose& X_AB, double depth_m) {
    if (IsDeeper(A_, points_B_m_, X_AB, 3.0 * depth_m)) return false;
    if (IsDeeper(B_, points_A_m_, X_AB.inverse(), 3.0 * depth_m)) return false;
    poses_.push_back({kind, X_AB});
    return true;
  }

  // Is any of B's points deeper in A?
  static bool IsDeeper(const oracle::MeshDistance& A, const std::vector<glm::dvec3>& points_B_m, const core::Pose& X_AB,
                       double depth_m) {
    return std::any_of(points_B_m.begin(), points_B_m.end(),
                       [&](const glm::dvec3& p) { return A.SignedDistance(X_AB * p) < -depth_m; });
  }

  // Corners and random places of the surface.
  std::vector<glm::dvec3> DrawPoints(const TriangleMesh& mesh, const Places& places) {
    constexpr std::size_t kMost = 1000;  // of each; not derived
    std::vector<glm::dvec3> points_m;
    const std::size_t step = mesh.vertices.size() / kMost + 1;
    for (std::size_t i = 0; i < mesh.vertices.size(); i += step) points_m.push_back(mesh.vertices[i]);
    for (std::size_t i = 0; i < kMost; ++i) points_m.push_back(places.DrawFace(&random_).p_m);
    return points_m;
  }

  CaseRandom& random_;
  oracle::MeshDistance A_, B_;
  Box box_A_, box_B_;
  Places places_A_, places_B_;
  double size_m_ = 0.0;
  std::vector<glm::dvec3> points_A_m_, points_B_m_;
  std::vector<ContactPose> poses_;
};

}  // namespace

std::string_view ToText(PoseKind kind) {
  constexpr std::array<std::string_view, kNumPoseKinds> kNames = {"light", "medium", "deep",   "sliding",
                                                                  "flat",  "edge",   "pressed"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::vector<ContactPose> MakeContactPoses(const TriangleMesh& A, const TriangleMesh& B, int count_each,
                                          CaseRandom* random) {
  return Poser(A, B, random).Run(count_each);
}

std::vector<ContactPose> MakePressedPoses(const TriangleMesh& mesh_A, const TriangleMesh& mesh_B, const PegFit& fit,
                                          int count, CaseRandom* random) {
  const oracle::MeshDistance A(mesh_A);
  const oracle::MeshDistance B(mesh_B);
  const double length_m = LongestSide(BoundingBox(mesh_B));
  const double size_m = std::min(LongestSide(BoundingBox(mesh_A)), length_m);
  std::vector<ContactPose> poses;
  for (int k = 0; k < kMostTries * count && static_cast<int>(poses.size()) < count; ++k) {
    const double tilt = fit.clearance_m / length_m;
    const core::Pose X_turned = {
        core::QuaternionFromRotationVector({random->Uniform(-tilt, tilt), random->Uniform(-tilt, tilt), 0.0}) *
            core::QuaternionFromRotationVector({0.0, 0.0, random->Uniform(-3.0, 3.0)}),
        {0.0, 0.0, random->Uniform(-fit.travel_m, fit.travel_m)}};
    core::Pose X_AB = fit.X_start * X_turned;
    const double side = random->Uniform(0.0, 6.28);
    const glm::dvec3 aside(std::cos(side), std::sin(side), 0.0);
    // Sphere tracing as in FindFirstTouch: a step of the distance cannot pass through.
    constexpr double kTouching_m = 1e-7;
    double distance_m = oracle::SurfaceDistance(A, B, X_AB);
    if (distance_m <= kTouching_m) continue;
    while (distance_m > kTouching_m) {
      X_AB.translation += distance_m * aside;
      distance_m = oracle::SurfaceDistance(A, B, X_AB);
    }
    X_AB.translation += LogUniform(1e-5, 1e-3, random) * size_m * aside;
    poses.push_back({PoseKind::kPressed, X_AB});
  }
  return poses;
}

}  // namespace vps
