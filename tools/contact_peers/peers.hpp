#pragma once

#include "tools/contact/method.hpp"

namespace contact_peers {

// FCL 0.7: two triangle trees (OBBRSS), all contacts. Force: sum of depth times normal; depth: the greatest.
core::Result<std::unique_ptr<contact::Method>> MakeFclMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B);

// Bullet 3.24 btGImpactMeshShape pair, margin 0, all manifold points.
core::Result<std::unique_ptr<contact::Method>> MakeGimpactMethod(const vps::TriangleMesh& A,
                                                                 const vps::TriangleMesh& B);

// OpenVDB level set of A (meshToLevelSet, half width 4), sampled trilinearly at all points of B, each with its share of
// B's area: the same integral as ours with another field and no tree.
core::Result<std::unique_ptr<contact::Method>> MakeOpenvdbMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                                 double voxel_size_m, std::uint32_t num_points);

}  // namespace contact_peers
