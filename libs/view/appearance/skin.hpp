#pragma once

#include <span>
#include <vector>

#include "core/pose.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace view {

// Linear blend skinning [Magnenat-Thalmann 1988]: a vertex goes with its joints, each as far as its weight says,
//   p_M = sum_k w_k X_MJk X_JkMBind p_MBind,
// and its normal with the same sum of rotations, made a unit vector again. So a skin keeps its thickness where one
// joint carries it, and grows thinner where joints that are turned against each other share it.
//
// Writes the positions and normals of `posed`, a copy of `mesh`. X_MJ: of each joint of the mesh (Instance::posture).
void BendSkin(const vps::VisualMesh& mesh, std::span<const core::Pose> X_MJ, vps::VisualMesh* posed);

// Where the file has its joints.
std::vector<core::Pose> RestPosture(const vps::VisualMesh& mesh);

}  // namespace view
