#pragma once

#include "core/pose.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/surface/surface_tree.hpp"

namespace contact {

// Conservative lower bound [voxels] of the exact signed distance at p (in the field's voxels): the field's distance
// less its error bound there.
float LowerBoundOfDistance(const vps::DistanceField& field, const glm::vec3& p);

// Conservative lower bound [m] of the distance between the surfaces of S and G (field), 0 when no positive bound is
// found. A place of a node lies within its radius r of its centre c, and distances are 1-Lipschitz, so
// d(x) >= LowerBoundOfDistance(c) - r. Branch and bound down the tree and into its triangles, nearest first; ends where
// the nearest part is small against its distance, or after kMostParts, with what is proven by then. Allocates.
double ApartBound_m(const vps::SurfaceTree& S, const vps::DistanceField& G, const core::Pose& X_GS);

}  // namespace contact
