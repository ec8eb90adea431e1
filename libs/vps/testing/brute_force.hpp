#pragma once

#include <vector>

#include "vps/query/tree_query.hpp"

namespace vps {

// The reference: Eq. 1 for every point, one after the other. Same arithmetic as the tree walk, so the same points and
// the same V to the last bit.
std::vector<PointHit> QueryBruteForce(const PointTree& sampled, const Voxmap& field, const core::Pose& X_GS,
                                      double margin_m);

}  // namespace vps
