#pragma once

#include <span>
#include <vector>

#include "vps/force/reduce_patches.hpp"
#include "vps/walk/evaluate_points.hpp"
#include "vps/walk/field_walk.hpp"

namespace vps {

// A sample that is refined: its finer points (FineBlock) replace it by its weight.
struct FinerSample {
  std::uint32_t near_block = 0;  // of the walk's
  std::uint32_t lane = 0;
  float depth_m = 0.0f;  // of the sample
  float weight = 0.0f;   // of its finer points against the sample itself, in [0, 1]
  float applied = 1.0f;  // share of their correction that is applied, in [0, 1]
  // Deepest of its finer points, and their correction of the sums.
  ContactPatch change;
};

// Weights of a block's samples: 0 for those that cannot be inside G.
struct NearSamples {
  std::uint32_t near_block = 0;  // of the walk's
  float weights[kBlock] = {};
};

struct RefineScratch {
  RefineScratch();
  // Samples that may be inside G, in the walk's order, and the sum of their weights.
  std::uint32_t num_near_blocks = 0;
  float sum_of_weights = 0.0f;
  float num_unrefined = 0.0f;  // samples near G without weight: of faces along G's, which SmallContact would cut up
  std::vector<NearSamples> near;
  // Of these, the samples refined by the last call, and how many near samples each of them represents.
  std::uint32_t num_samples = 0;
  float num_represented = 1.0f;
  // Estimates from the finer points inside G, or just outside and then with less weight: their number, by their
  // samples' weights, their area, and the integral of their depth.
  float num_near = 0.0f;
  float near_m2 = 0.0f;
  float volume_m3 = 0.0f;
  float rim_m3 = 0.0f;  // error of that integral at the contact's rim
  float error = 0.0f;   // of the field around the samples, voxels; 0 where there are no facets for exact depths

  // Shares in [0, 1]: of SmallContact in the contact, and of exact depths in SmallContact.
  float share_of_small = 0.0f;
  float share_of_exact = 0.0f;
  std::vector<FinerSample> samples;
  std::vector<FineSource> sources;
  std::vector<FinePoints> found;
};

// Adaptive refinement: replaces samples of a walk that may be inside G by their finer points (decision 9). These are
// the samples at a depth d > -r, where r is the reach of the patch towards G; the weight of the finer points fades out
// towards -r. Where such samples are many, some of them are refined and represent all: then errors of single samples
// average out and are not corrected; errors of whole rows of samples along a sharp edge do not, and are. Of a broad
// contact, with many samples inside, none is refined. Force and moment stay continuous.
//
// Deep samples are refined, too: a single sample underestimates the integral where the depth is convex, as where G's
// surface cuts the patch, and overestimates it where the depth is concave, as inside a round G (by h^2 / 12 R for a
// spacing h). Over a whole contact the two nearly cancel; correcting the first alone makes the force of a deep contact
// of few samples 5 % too large. The smallest and shallowest contacts need SmallContact.
void RefineContact(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                   const FieldWalkResult& walk, const FieldWalkScratch& walk_scratch, RefineScratch* scratch);

}  // namespace vps
