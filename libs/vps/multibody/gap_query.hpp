#pragma once

#include "vps/multibody/fast_pair_query.hpp"
#include "vps/multibody/gap/gap_planes.hpp"
#include "vps/sampling/touch_points.hpp"

namespace vps {

// FinishFastPair's counterpart, after a walk of S.tree with the look-ahead as margin. Penalty integrals are those of
// the points alone. result->planes are the nearest of gaps->planes.
double FinishGapPair(const TouchPoints& S, const DistanceField& field, const core::Pose& X_WS, const core::Pose& X_GS,
                     const PairDescription& pair, double rho, FastPairScratch* scratch, GapPlanes* gaps,
                     PairResult* result);

}  // namespace vps
