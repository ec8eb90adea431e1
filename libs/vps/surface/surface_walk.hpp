#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/pose.hpp"
#include "vps/force/reduce_patches.hpp"
#include "vps/surface/field_bends.hpp"
#include "vps/surface/patch_block.hpp"
#include "vps/surface/surface_memory.hpp"
#include "vps/surface/surface_tree.hpp"
#include "vps/walk/field_walk.hpp"

namespace vps {

// Estimates of errors are that many standard deviations. How many contacts are within them: docs/performance/vps.md,
// what an accuracy costs.
constexpr double kConfidence = 2.0;

// What a query has to be good for.
struct SurfaceGoal {
  double accuracy = 0.02;               // wanted error of the force over the integral of depth
  double negligible_m3 = 0.0;           // an error that does not count whatever the accuracy
  std::uint64_t most_places = 200'000;  // that may be read; by triangles near the surface uncounted
  double offset_m = 0.0;                // as if G were larger by that on all sides
};

// The contact wrench of S's surface in the field of G to a wanted accuracy, with an estimate of its error.
//
//   force = integral over S of max(depth, 0) n dA,   moment = integral of (x X n) max(depth, 0) dA,
//
// n: inward normal. A walk goes down S's tree and into its triangles. A patch whose share of the error is below a
// threshold is integrated in closed form; one with a larger share is opened, or its depth is read from G's triangles.
// README.md derives the parts of the estimate.
class SurfaceWalk {
 public:
  struct Result {
    glm::dvec3 force_m3{0.0};   // in S
    glm::dvec3 moment_m4{0.0};  // about S's mesh origin, in S
    double volume_m3 = 0.0;     // integral of depth
    double square_m4 = 0.0;     // integral of its square
    double deepest_m = 0.0;     // greatest depth of what was kept, by the patches' models
    glm::vec3 deepest_p_S{0.0f};
    double error_m3 = 0.0;  // estimate of |force - the exact one|
    // error_m3 is at most the greater of the accuracy times volume_m3 and negligible_m3. Else places or passes ran out,
    // rounding is more, or of a known pair the next pass would not fit into the budget.
    bool is_accurate = false;
    std::uint64_t patches_inside = 0;
    std::uint64_t places_read = 0;  // in all passes; a search deep inside counts as kPlacesOfSearch
    int passes = 0;
  };

  explicit SurfaceWalk(InstructionSet set = BestInstructionSet());

  // Makes room for queries with goals of at most so many places, which then do not allocate.
  void Reserve(std::size_t most_places);

  // X_GS: pose of S in G. `bends`: of the same field. In passes with smaller and smaller thresholds until the estimate
  // is small enough, or places run out. Without a memory the result does not depend on earlier calls. Does not allocate
  // after Reserve, or once its lists have grown.
  const Result& Run(const SurfaceTree& S, const DistanceField& G, const FieldBends& bends, const core::Pose& X_GS,
                    const SurfaceGoal& goal, SurfaceMemory* memory = nullptr);

  // That of a query in which nothing touches.
  const Result& ClearResult() {
    result_ = {};
    result_.is_accurate = true;
    num_parts_ = 0;
    return result_;
  }

  [[nodiscard]] const Result& result() const { return result_; }  // of the last query
  // Of the last query: what touches, at most kMostParts, which add up to the whole: where there are more, neighbours
  // in S are added up.
  static constexpr std::size_t kMostParts = 256;
  [[nodiscard]] std::span<const ContactPatch> parts() const { return {parts_.data(), num_parts_}; }

 private:
  // A patch whose parts are to be read.
  struct Opened {
    float model[kModelRows];
    bool is_flat;
    std::uint32_t below;  // the family of its children, unless it is flat
    SurfacePiece triangle;
    float radius, area, area_vector[3], spread[6];  // of a flat one
    // And what it counts as itself if it is not opened after all.
    float force[3], moment[3], volume, square, bias, deviation;
  };
  // The lanes of a block: where their children are.
  struct Origins {
    std::uint32_t below[kPatchLanes];
    SurfacePiece triangles[kPatchLanes];
  };
  struct Level {
    std::vector<Opened> by_field, by_triangles;
  };
  // What opening a patch of a level would take.
  struct Asked {
    float share;
    std::uint64_t places;
  };
  // What the next pass may open.
  struct Kept {
    PatchesRead patches;
    Origins origins;
  };

  void SetPose(const core::Pose& X_GS);
  bool Pass(double threshold_m3, double deviation_m3);
  static void SetCorners(const SurfacePiece& triangle, std::size_t lane, PatchBlock* block, Origins* origins);
  void FillRoots(PatchBlock* block, Origins* origins) const;
  void FillParts(const Opened* opened, std::size_t count, PatchBlock* block, Origins* origins) const;
  void ReadByField(const std::vector<Opened>& opened);
  void ReadByTriangles(const std::vector<Opened>& opened);
  void ReadAgain();
  void ReadExactDepths();
  void ReadOneByOne(PatchBlock* block);
  void SetExact(float depth_m, const glm::vec3& gradient, int lane, PatchBlock* block) const;
  void Judge(PatchBlock* block, const Origins& origins);
  void Keep(const PatchBlock& block, const Origins& origins);
  void JudgeKept();
  void JudgeRoots();
  void Put(const PatchBlock& block, const Origins& origins, int lane);
  [[nodiscard]] float ShareOf(const Opened& o) const;
  [[nodiscard]] float deepest_exact_m() const;
  bool TakeSearch(float depth_m);
  bool FitLevel();
  void PutAgain(const PatchBlock& block, const Origins& origins, int lane);
  void KeepUnopened(const Opened& o);

  void AddParts(const PatchBlock& block);
  ContactPatch* NextPart();
  void SetDeepest(const PatchBlock& block, int lane);

  const SurfaceTree* S_ = nullptr;
  const DistanceField* G_ = nullptr;
  const FieldBends* bends_ = nullptr;
  std::uint64_t most_places_ = 0;
  WalkKernels kernels_;
  PatchInput in_{};
  PatchSums sums_{};
  Level now_, next_;
  std::vector<Asked> asked_;
  std::vector<Kept> kept_, last_kept_;
  std::vector<ContactPatch> parts_;
  std::size_t num_parts_ = 0;
  std::vector<PatchBlock> exact_;  // blocks whose depths are read by triangles together
  std::vector<Origins> exact_origins_;
  std::vector<FacetPoints> facet_points_;
  std::unique_ptr<FacetScratch> facets_;
  PatchBlock again_{};  // patches that are to be read by triangles
  Origins again_origins_{};
  int num_again_ = 0;
  std::size_t num_exact_ = 0;
  double lasting_m3_ = 0.0;  // of the last pass: error that no opening makes smaller
  Result result_;
};

}  // namespace vps
