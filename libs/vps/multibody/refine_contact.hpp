#pragma once

#include <span>
#include <vector>

#include "vps/force/reduce_patches.hpp"
#include "vps/walk/evaluate_points.hpp"
#include "vps/walk/field_walk.hpp"

namespace vps {

// A small contact is seen by few samples. Where it is, the finer points of each sample (FineBlock) stand in for it.
struct FinerSample {
  std::uint32_t near_block = 0;  // of the walk's
  std::uint32_t lane = 0;
  float depth_m = 0.0f;  // of the sample
  float weight = 0.0f;   // share that its finer points have in what the sample stands for
  float told = 1.0f;     // how much of what they change counts
  // Deepest of its finer points, and, of FindChangesOfSums, what they change in the sums.
  ContactPatch change;
};

// Of a block, those that may be inside G: each sample's weight.
struct NearSamples {
  std::uint32_t near_block = 0;  // of the walk's
  float weights[kBlock] = {};
};

struct RefineScratch {
  RefineScratch();
  // Samples that may be inside G, in the walk's order, and the sum of their weights.
  std::uint32_t num_near_blocks = 0;
  float sum_of_weights = 0.0f;
  float num_unseen = 0.0f;  // others, of faces that lie along G's so near that SmallContact would look at them
  std::vector<NearSamples> near;
  // Of these, those whose finer points the last call looked at, and how many each of them stands for.
  std::uint32_t num_samples = 0;
  float stand_for = 1.0f;
  // Of the finer points that are inside G, or just outside and then less: how many there are, by their samples'
  // weights, how much surface they stand for, and the integral of their depth.
  float num_near = 0.0f;
  float near_m2 = 0.0f;
  float volume_m3 = 0.0f;
  float rim_m3 = 0.0f;  // what the finer points may miss of it at the contact's rim
  float error = 0.0f;   // of the field around the samples, voxels; 0 where there are no facets to tell more
  // How much of the contact SmallContact is to tell, and how far it is to go from the field's depths to exact ones.
  float share_of_small = 0.0f;
  float share_of_exact = 0.0f;
  std::vector<FinerSample> samples;
  std::vector<PointBlock> points;
  std::vector<SphereBlock> spheres;
  std::vector<BlockDepths> depths;
};

// Looks more closely at the samples of a walk that may be inside G: those at a depth d > -r, where r is how far the
// patch reaches towards G. The finer points' weight fades out towards -r. Where such samples are many, a share of them
// is looked at and stands for all. What single ones are off by averages out then and is left alone; what whole rows of
// them miss along a sharp edge does not, and is told. Of a broad contact, of many samples inside, none is looked at.
// Force and moment stay continuous.
//
// Deep samples, too: one sample tells too little where the depth bends upwards, as it does where G's surface cuts the
// patch, and too much where it bends downwards, as inside a round G (by h^2 / 12 R for a spacing h). Of a whole contact
// the two nearly cancel. To mend the first alone makes the force of a deep contact of few samples 5 % too large.
// The smallest and shallowest contacts need more than that: SmallContact.
void RefineContact(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                   const FieldWalkResult& walk, const FieldWalkScratch& walk_scratch, RefineScratch* scratch);

// After RefineContact, which leaves this out because SmallContact may tell all of it: what the finer points change in
// the sums.
void FindChangesOfSums(const SampleTree& sampled, const DistanceField& field, const FieldWalkScratch& walk_scratch,
                       RefineScratch* scratch);

}  // namespace vps
