#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include "tools/contact_peers/bullet_pair.hpp"

namespace contact_peers {
namespace {

struct Body {
  explicit Body(const vps::TriangleMesh& mesh) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto [a, b, c] = mesh.corners(i);
      triangles.addTriangle({a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z});
    }
    shape = std::make_unique<btGImpactMeshShape>(&triangles);
    shape->setMargin(0.0);
    shape->updateBound();
    object.setCollisionShape(shape.get());
  }
  btTriangleMesh triangles;
  std::unique_ptr<btGImpactMeshShape> shape;
  btCollisionObject object;
};

class GimpactMethod : public contact::Method {
 public:
  GimpactMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B) : a_(A), b_(B) {
    btGImpactCollisionAlgorithm::registerAlgorithm(pair_.dispatcher());
  }

  contact::Answer Query(const core::Pose& X_AB) override { return pair_.Query(X_AB); }

 private:
  Body a_;
  Body b_;
  BulletPair pair_{&a_.object, &b_.object};
};

}  // namespace

core::Result<std::unique_ptr<contact::Method>> MakeGimpactMethod(const vps::TriangleMesh& A,
                                                                 const vps::TriangleMesh& B) {
  return std::make_unique<GimpactMethod>(A, B);
}

}  // namespace contact_peers
