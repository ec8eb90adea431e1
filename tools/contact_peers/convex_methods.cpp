#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btShapeHull.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>
#include <HACD/hacdHACD.h>
#include <LinearMath/btConvexHullComputer.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "tools/contact_peers/bullet_pair.hpp"
#include "tools/contact_peers/peers.hpp"

namespace contact_peers {
namespace {

// Not derived: HACD's time grows from seconds to minutes with its triangles, and it does not end on some meshes.
constexpr std::size_t kMaxTriangles = 3000;
constexpr std::size_t kMinParts = 8;
constexpr unsigned kMaxSeconds = 4;

btVector3 ToBullet(const glm::dvec3& v) {
  return {btScalar(v.x), btScalar(v.y), btScalar(v.z)};
}

btTransform ToBullet(const core::Pose& X) {
  const glm::dquat& q = X.rotation;
  return btTransform(btQuaternion(btScalar(q.x), btScalar(q.y), btScalar(q.z), btScalar(q.w)), ToBullet(X.translation));
}

// Vertex clustering: vertices in one cell of a grid become their mean. The finest grid, from 128 cells along the
// longest side by factors of 4/5, that leaves at most kMaxTriangles.
vps::TriangleMesh Thinned(const vps::TriangleMesh& mesh) {
  if (mesh.triangles.size() <= kMaxTriangles) return mesh;
  const vps::Box box = vps::BoundingBox(mesh);
  const glm::dvec3 size = box.upper - box.lower;
  for (int cells = 128;; cells = cells * 4 / 5) {
    const double cell = std::max({size.x, size.y, size.z}) / cells;
    std::map<std::array<int, 3>, std::uint32_t> index;
    std::vector<std::uint32_t> to(mesh.vertices.size());
    std::vector<int> count;
    vps::TriangleMesh thin;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const glm::dvec3 at = (mesh.vertices[i] - box.lower) / cell;
      const auto [entry, is_new] =
          index.try_emplace({int(at.x), int(at.y), int(at.z)}, static_cast<std::uint32_t>(thin.vertices.size()));
      if (is_new) {
        thin.vertices.emplace_back(0.0);
        count.push_back(0);
      }
      to[i] = entry->second;
      thin.vertices[to[i]] += mesh.vertices[i];
      ++count[to[i]];
    }
    for (std::size_t i = 0; i < count.size(); ++i) thin.vertices[i] /= count[i];
    for (const auto& t : mesh.triangles) {
      const std::uint32_t a = to[t[0]], b = to[t[1]], c = to[t[2]];
      if (a != b && b != c && a != c) thin.triangles.push_back({a, b, c});
    }
    if (thin.triangles.size() <= kMaxTriangles) return thin;
  }
}

std::unique_ptr<btConvexHullShape> Hull(const std::vector<glm::dvec3>& points) {
  std::vector<double> coordinates;
  for (const glm::dvec3& p : points) coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
  btConvexHullComputer computer;
  computer.compute(coordinates.data(), 3 * sizeof(double), static_cast<int>(points.size()), 0.0, 0.0);
  auto hull = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < computer.vertices.size(); ++i) hull->addPoint(computer.vertices[i], false);
  hull->recalcLocalAabb();
  hull->setMargin(0.0);
  return hull;
}

std::vector<std::vector<glm::dvec3>> Decompose(const vps::TriangleMesh& mesh) {
  const vps::TriangleMesh thin = Thinned(mesh);
  std::vector<HACD::Vec3<HACD::Real>> points;
  for (const glm::dvec3& v : thin.vertices) points.emplace_back(v.x, v.y, v.z);
  std::vector<HACD::Vec3<long>> triangles;
  for (const auto& t : thin.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  HACD::HACD hacd;
  hacd.SetPoints(points.data());
  hacd.SetNPoints(points.size());
  hacd.SetTriangles(triangles.data());
  hacd.SetNTriangles(triangles.size());
  hacd.SetCompacityWeight(0.1);
  hacd.SetVolumeWeight(0.0);
  hacd.SetNClusters(kMinParts);
  hacd.SetNVerticesPerCH(100);
  hacd.SetConcavity(100.0);  // of a mesh scaled to 1000
  hacd.SetAddExtraDistPoints(false);
  hacd.SetAddNeighboursDistPoints(false);
  hacd.SetAddFacesPoints(false);
  std::vector<std::vector<glm::dvec3>> parts;
  if (!hacd.Compute()) return parts;
  for (std::size_t k = 0; k < hacd.GetNClusters(); ++k) {
    std::vector<HACD::Vec3<HACD::Real>> corners(hacd.GetNPointsCH(k));
    std::vector<HACD::Vec3<long>> faces(hacd.GetNTrianglesCH(k));
    hacd.GetCH(k, corners.data(), faces.data());
    if (corners.size() < 4) continue;
    parts.emplace_back();
    for (const auto& c : corners) parts.back().emplace_back(c.X(), c.Y(), c.Z());
  }
  return parts;
}

// Decompose in a process of its own, which is ended after kMaxSeconds; empty when it is ended.
std::vector<std::vector<glm::dvec3>> DecomposeInTime(const vps::TriangleMesh& mesh) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    alarm(kMaxSeconds);
    FILE* const out = fdopen(ends[1], "w");
    for (const auto& part : Decompose(mesh)) {
      const std::size_t count = part.size();
      std::fwrite(&count, sizeof(count), 1, out);
      std::fwrite(part.data(), sizeof(glm::dvec3), count, out);
    }
    std::fflush(out);
    _exit(0);
  }
  close(ends[1]);
  std::vector<std::vector<glm::dvec3>> parts;
  FILE* const in = fdopen(ends[0], "r");
  std::size_t count = 0;
  while (std::fread(&count, sizeof(count), 1, in) == 1) {
    std::vector<glm::dvec3> part(count);
    if (std::fread(part.data(), sizeof(glm::dvec3), count, in) != count) break;
    parts.push_back(std::move(part));
  }
  std::fclose(in);
  waitpid(child, nullptr, 0);
  return parts;
}

struct Body {
  explicit Body(const vps::TriangleMesh& mesh) {
    for (const auto& part : DecomposeInTime(mesh)) {
      parts.push_back(Hull(part));
      shape.addChildShape(btTransform::getIdentity(), parts.back().get());
    }
    object.setCollisionShape(&shape);
  }
  std::vector<std::unique_ptr<btConvexHullShape>> parts;
  btCompoundShape shape;
  btCollisionObject object;
};

class ConvexPartsMethod : public contact::Method {
 public:
  ConvexPartsMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B) : a_(A), b_(B) {}

  [[nodiscard]] bool has_parts() const { return !a_.parts.empty() && !b_.parts.empty(); }

  contact::Answer Query(const core::Pose& X_AB) override { return pair_.Query(X_AB); }

 private:
  Body a_;
  Body b_;
  BulletPair pair_{&a_.object, &b_.object};
};

class HullMethod : public contact::Method {
 public:
  HullMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B) : a_(Hull(A.vertices)), b_(Hull(B.vertices)) {}

  contact::Answer Query(const core::Pose& X_AB) override {
    const btTransform X_A = btTransform::getIdentity();
    const btTransform X_B = ToBullet(X_AB);
    const btVector3 guess = X_B.getOrigin();
    btGjkEpaSolver2::sResults result;
    contact::Answer answer;
    answer.points_tested = 1;
    if (!btGjkEpaSolver2::Penetration(a_.get(), X_A, b_.get(), X_B, guess, result)) return answer;
    // The normal points from B to A.
    const glm::dvec3 n(result.normal.x(), result.normal.y(), result.normal.z());
    answer.signed_distance_m = -std::abs(double(result.distance));
    answer.force_A = -answer.signed_distance_m * -n;
    answer.contacts = 1;
    return answer;
  }

 private:
  std::unique_ptr<btConvexHullShape> a_;
  std::unique_ptr<btConvexHullShape> b_;
};

}  // namespace

core::Result<std::unique_ptr<contact::Method>> MakeConvexPartsMethod(const vps::TriangleMesh& A,
                                                                     const vps::TriangleMesh& B) {
  auto method = std::make_unique<ConvexPartsMethod>(A, B);
  if (!method->has_parts()) return core::Fail(core::ErrorCode::kInvalidInput, "HACD gives no parts within 4 s");
  return method;
}

core::Result<std::unique_ptr<contact::Method>> MakeHullMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B) {
  return std::make_unique<HullMethod>(A, B);
}

}  // namespace contact_peers
