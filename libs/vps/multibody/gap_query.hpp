#pragma once

#include "vps/multibody/fast_pair_query.hpp"
#include "vps/multibody/gap/gap_planes.hpp"
#include "vps/sampling/touch_points.hpp"

namespace vps {

// FinishFastPair's counterpart, after a walk of touch.tree with WalkMargin_m. result->planes are the
// nearest of gaps->planes.
double FinishGapPair(const FastPair& parts, const TouchPoints& touch, const core::Pose& X_WS, const core::Pose& X_GS,
                     const PairDescription& pair, double rho, FastPairScratch* scratch, GapPlanes* gaps,
                     PairResult* result);

}  // namespace vps
