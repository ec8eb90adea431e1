#pragma once

#include <vector>

#include "vps/force/reduce_contacts.hpp"
#include "vps/multibody/collision_world.hpp"
#include "vps/query/tree_query.hpp"

namespace vps {

// At most about this many contacts of a pair enter the reduction to planes. Beyond it every second, fourth ... point of
// the tree counts (neighbours in the tree are neighbours on the surface), always the same ones, and the deepest. Not
// derived: bounds the time of ReduceContacts.
constexpr std::uint32_t kMaxReducedContacts = 1024;

// Memory of one pair, allocated once.
struct PairScratch {
  explicit PairScratch(const PointTree& tree) : query(tree), contacts(kMaxReducedContacts + 1) {}
  QueryScratch query;
  std::vector<SampledContact> contacts;
};

// One pair, from poses to forces and planes: tree walk, Eq. 1 and 2, reduction. Fills everything in `result` but its
// cycle. Returns the distance by which the two objects may move against each other before the result can change from
// "apart, no plane": 0 while there are planes.
double QueryPair(const PointTree& sampled, const Voxmap& field, const core::Pose& X_WS, const core::Pose& X_GS,
                 const PairDescription& pair, double rho, double alpha, PairScratch* scratch, PairResult* result);

}  // namespace vps
