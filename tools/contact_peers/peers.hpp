#pragma once

#include "tools/contact/methods/method.hpp"
#include "tools/contact/structures.hpp"

namespace contact_peers {

// FCL 0.7: two triangle trees (OBBRSS), all contacts. Force: sum of depth times normal; depth: the greatest.
core::Result<std::unique_ptr<contact::Method>> MakeFclMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B);

// Bullet 3.24 btGImpactMeshShape pair, margin 0, all manifold points.
core::Result<std::unique_ptr<contact::Method>> MakeGimpactMethod(const vps::TriangleMesh& A,
                                                                 const vps::TriangleMesh& B);

// Bullet compounds of convex hulls by Bullet's hierarchical approximate convex decomposition (HACD), of a mesh reduced
// to 3000 triangles by vertex clustering, because HACD takes minutes for more. Errors: HACD gives no parts within 4 s.
core::Result<std::unique_ptr<contact::Method>> MakeConvexPartsMethod(const vps::TriangleMesh& A,
                                                                     const vps::TriangleMesh& B);

// One GJK/EPA call (Bullet's) on the convex hulls of both meshes.
core::Result<std::unique_ptr<contact::Method>> MakeHullMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B);

// OpenVDB level set of A (meshToLevelSet, half width 4), sampled trilinearly at the points of B that `fast` uses, each
// with its area: the same quadrature as `fast` with another field and without culling.
core::Result<std::unique_ptr<contact::Method>> MakeOpenvdbMethod(const contact::Parts& parts, double voxel_size_m,
                                                                 contact::Structures* structures);

}  // namespace contact_peers
