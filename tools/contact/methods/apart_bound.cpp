#include "tools/contact/methods/apart_bound.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

#include "vps/walk/walk_input.hpp"

namespace contact {
namespace {

// Bound of the rounding of a stored distance [voxels]: 1/512 in the band (field_word.hpp), 2^-15 of the distance in the
// coarse grid, which is 0.02 at 650 voxels.
constexpr float kRounding = 0.02f;
// Bound of the error of fitted planes [voxels]: at most 0.3 is measured (DistanceField.NearTheSurface*); the rest is a
// margin that is not derived.
constexpr float kWorstInBand = 0.5f;

struct Centre {
  float distance;    // signed, at the centre [voxels]; -1e30 inside the band
  glm::vec3 centre;  // [voxels]
};
// Of the coarse cell that holds p.
Centre CentreOf(const vps::DistanceField& field, const glm::vec3& p) {
  const vps::FieldSample sample = vps::SampleField(field, p);
  return {sample.cell > 1.0f ? sample.centre_distance : -1e30f, (glm::floor(p / sample.cell) + 0.5f) * sample.cell};
}

glm::vec3 PointOf(const vps::PointBlock& block, std::uint32_t k) {
  return {block.x[k], block.y[k], block.z[k]};
}

}  // namespace

float LowerBoundOfDistance(const vps::DistanceField& field, const glm::vec3& p) {
  const vps::FieldSample sample = vps::SampleField(field, p);
  const glm::vec3 last(static_cast<float>(field.nx) - 0.5f, static_cast<float>(field.ny) - 0.5f,
                       static_cast<float>(field.nz) - 0.5f);
  const glm::vec3 q = glm::clamp(p, glm::vec3(0.0f), last);
  const bool is_in_band = sample.cell == 1.0f;
  const bool is_crease = is_in_band && sample.centre_offset == 0.0f;
  // Distance is 1-Lipschitz: d(q) >= d(c) - |q - c| for the cell's centre c.
  float least = is_crease ? -1e30f : sample.centre_distance - sample.centre_offset - kRounding;
  if (is_in_band) least = std::max(least, sample.distance - kWorstInBand);
  // The same from cells farther out along the gradient. From a centre at a along and l across it the bound loses
  // sqrt(a^2 + l^2) - a <= l^2 / (2 a), less the farther the centre.
  if (!is_in_band) {
    for (const float ahead : {1.0f, 2.0f, 4.0f, 8.0f}) {
      const glm::vec3 at = q + ahead * sample.cell * glm::normalize(sample.gradient);
      if (at != glm::clamp(at, glm::vec3(0.0f), last)) break;
      const Centre farther = CentreOf(field, at);
      least = std::max(least, farther.distance - glm::length(q - farther.centre) - kRounding);
    }
  }
  if (p == q) return least;
  // p is outside the grid, q its nearest place there. The surface keeps kMinBorder voxels from the grid's faces, so
  // d(p) is at least the distance to that smaller box. And the grid is convex: for x on the surface the angle at q
  // between p and x is at least 90 degrees, so |p - x|^2 >= |p - q|^2 + |q - x|^2.
  const glm::vec3 border(static_cast<float>(vps::DistanceField::kMinBorder) - 0.5f);
  const float to_box = glm::length(p - glm::clamp(p, border, last - border));
  return std::max(to_box, std::hypot(glm::length(p - q), std::max(least, 0.0f)));
}

namespace {

// A node of the branch and bound: a part of S with a lower bound of its distance from G [voxels]. A sphere of the tree,
// bounded by the coarse grid (kSphere), then by LowerBoundOfDistance at its centre (kSphereRefined); a sample's patch,
// bounded from the sample (kPatch), then from its finer points (kFinerPatch), which is final.
struct Part {
  enum Kind : std::uint8_t { kSphere, kSphereRefined, kPatch, kFinerPatch };
  float bound;
  Kind kind;
  std::uint32_t level;   // of a sphere
  std::uint32_t number;  // of the sphere in its level; of the sample

  // std::priority_queue takes the greatest: the nearest part.
  bool operator<(const Part& other) const { return bound > other.bound; }
};

class Search {
 public:
  Search(const vps::SampleTree& sampled, const vps::DistanceField& field, const core::Pose& X_GS)
      : sampled_(sampled),
        field_(field),
        T_(X_GS, field),
        in_(vps::MakeFieldInput(field, X_GS)),
        kernels_(vps::KernelsOf(vps::BestInstructionSet())),
        voxels_per_m_(static_cast<float>(1.0 / field.voxel_size_m)) {
    in_.spheres = sampled.spheres.data();
  }

  // The bound [voxels].
  float Run() {
    least_ = BoundOfANearSample();
    PushChildren(sampled_.num_levels - 1, 0);
    while (!parts_.empty()) {
      const Part part = parts_.top();
      parts_.pop();
      // All other parts have bounds at least as great.
      if (part.kind == Part::kFinerPatch || part.bound >= least_ - kTolerance * least_) return part.bound;
      Split(part);
    }
    return 0.0f;
  }

 private:
  // Pushes the 16 spheres of a block, bounded by the coarse grid.
  void PushChildren(std::uint32_t level, std::uint32_t block) {
    std::int32_t keys[vps::kBlock];
    kernels_.bound(in_, sampled_.level_begin[level] + block, keys);
    for (std::uint32_t k = 0; k < vps::kBlock; ++k) {
      const float bound = static_cast<float>(keys[k] >> 4) / static_cast<float>(vps::kFreeDistanceSteps);
      if (bound > vps::kMaxFreeDistance) continue;
      parts_.push({bound - InVoxels(sampled_.reach_m), Part::kSphere, level, block * vps::kBlock + k});
    }
  }
  void Split(const Part& part) {
    switch (part.kind) {
      case Part::kSphere: {
        const vps::SphereBlock& spheres =
            sampled_.spheres[sampled_.level_begin[part.level] + part.number / vps::kBlock];
        const std::uint32_t k = part.number % vps::kBlock;
        const float bound = AtLeast({spheres.x[k], spheres.y[k], spheres.z[k]}) - InVoxels(sampled_.reach_m) -
                            InVoxels(static_cast<double>(spheres.r[k]));
        parts_.push({std::max(bound, part.bound), Part::kSphereRefined, part.level, part.number});
        return;
      }
      case Part::kSphereRefined:
        if (part.level > 0) {
          PushChildren(part.level - 1, part.number);
          return;
        }
        for (std::uint32_t i = part.number * vps::kBlock;
             i < std::min(sampled_.num_points, (part.number + 1) * vps::kBlock); ++i) {
          Push({std::max(BoundOf(i), part.bound), sampled_.fine.empty() ? Part::kFinerPatch : Part::kPatch, 0, i});
        }
        return;
      case Part::kPatch:
        Push({std::max(FinerBound(part.number), part.bound), Part::kFinerPatch, 0, part.number});
        return;
      case Part::kFinerPatch:
        return;
    }
  }
  // The bound of the sample found by descending to the nearest child at each level: prunes the rest.
  float BoundOfANearSample() const {
    std::uint32_t number = 0;
    for (std::uint32_t level = sampled_.num_levels; level-- > 0;) {
      std::int32_t keys[vps::kBlock];
      kernels_.bound(in_, sampled_.level_begin[level] + number, keys);
      number =
          number * vps::kBlock + static_cast<std::uint32_t>(*std::min_element(keys, keys + vps::kBlock)) % vps::kBlock;
    }
    return sampled_.fine.empty() ? BoundOf(number * vps::kBlock) : FinerBound(number * vps::kBlock);
  }
  float BoundOf(std::uint32_t sample) const {
    const double reach_m =
        sampled_.fine.empty() ? sampled_.reach_m : static_cast<double>(sampled_.fine[sample].reach_m);
    return AtLeast(PointOf(sampled_.points[sample / vps::kBlock], sample % vps::kBlock)) - InVoxels(reach_m);
  }
  float FinerBound(std::uint32_t sample) const {
    const vps::FineBlock& fine = sampled_.fine[sample];
    vps::PointBlock points;
    vps::Unpack(fine, sampled_.points[sample / vps::kBlock], sample % vps::kBlock, 1.0f, &points);
    float nearest = 1e30f;
    for (std::uint32_t k = 0; k < vps::kBlock; ++k) {
      if (fine.share[k] > 0) nearest = std::min(nearest, AtLeast(PointOf(points, k)));
    }
    return nearest - InVoxels(static_cast<double>(fine.cover_m));
  }
  void Push(const Part& part) {
    parts_.push(part);
    if (part.kind == Part::kFinerPatch) least_ = std::min(least_, part.bound);
  }
  [[nodiscard]] float AtLeast(const glm::vec3& p_S) const { return LowerBoundOfDistance(field_, T_.ToVoxels(p_S)); }
  [[nodiscard]] float InVoxels(double length_m) const { return static_cast<float>(length_m) * voxels_per_m_; }

  // Relative: the search ends when no part is nearer than (1 - kTolerance) of the nearest found. Not derived: tightness
  // against parts split.
  static constexpr float kTolerance = 0.02f;

  const vps::SampleTree& sampled_;
  const vps::DistanceField& field_;
  vps::FieldTransform T_;
  vps::WalkInput in_;
  vps::WalkKernels kernels_;
  float voxels_per_m_;
  std::priority_queue<Part> parts_;
  float least_ = 1e30f;
};

}  // namespace

double ApartBound_m(const vps::SampleTree& sampled, const vps::DistanceField& field, const core::Pose& X_GS) {
  return std::max(0.0, static_cast<double>(Search(sampled, field, X_GS).Run()) * field.voxel_size_m);
}

}  // namespace contact
