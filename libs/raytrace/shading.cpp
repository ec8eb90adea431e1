#include "raytrace/shading.hpp"

#include <algorithm>
#include <cmath>

#include "raytrace/sampling.hpp"
#include "view/appearance/environment_light.hpp"

namespace raytrace {
namespace {

// A surface rougher than this spreads its mirror image so far that the surroundings' light stands for it; between both
// the image fades out. By eye.
constexpr float kSharp = 0.15f, kBlurred = 0.35f;
constexpr float kLeastShare = 0.02f;  // of the light: less is not followed
// Surfaces of one thing whose normals differ by less (cosine) mirror nearly the same. By eye.
constexpr float kSameNormal = 0.995f;
// Through glass: in and out of two panes, and once more.
constexpr int kMostDepth = 6;
// What is farther away hides nothing of the surroundings: it would have to shine by itself instead. By eye.
constexpr float kHides_m = 0.3f;

float Most(const glm::vec3& color) {
  return std::max(color.r, std::max(color.g, color.b));
}

// Lanes in the order of two by two pixels.
constexpr std::array<std::array<int, 4>, 4> kQuads = {{{0, 1, 4, 5}, {2, 3, 6, 7}, {8, 9, 12, 13}, {10, 11, 14, 15}}};

}  // namespace

void Shading::FollowFromEye(const Rays& rays, int x, int y, glm::vec3* light) const {
  const Square square{x, y};
  Follow(rays, Far{}, 0, &square, light);
}

void Shading::Follow(const Rays& rays, const Far& far_m, int depth, const Square* square, glm::vec3* light) const {
  Hits hits;
  for (int lane = 0; lane < kLanes; ++lane) {
    if (!rays.HasHit(lane)) continue;
    const auto i = static_cast<std::size_t>(lane);
    hits.far_m[i] = far_m[i] + rays.embree.ray.tfar[lane] * glm::length(rays.Along(lane));
    hits.surfaces[i] = world_.SurfaceAt(rays.PlaceOf(lane, spread_ * hits.far_m[i]));
    const bool is_inside = hits.surfaces[i].is_back && hits.surfaces[i].transmission > 0.0f;
    if (!is_inside) hits.parts[i] = lighting_.Reflect(hits.surfaces[i]);
    light[lane] = hits.parts[i].rest;
  }
  AddSun(rays, hits, square, light);
  AddSurroundings(rays, hits, square, light);
  AddMirrored(rays, hits, depth, light);
  AddThrough(rays, hits, depth, light);
}

void Shading::AddSun(const Rays& rays, const Hits& hits, const Square* square, glm::vec3* light) const {
  Rays shadow;
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto i = static_cast<std::size_t>(lane);
    if (!rays.HasHit(lane) || hits.parts[i].sun == glm::vec3(0.0f)) continue;
    glm::vec3 to_sun_W = lighting_.to_sun_W();
    if (square != nullptr && quality_.sample > 0) {
      const Samples samples(quality_.sample, square->x + lane % kSide, square->y + lane / kSide);
      to_sun_W = WithinDisc(to_sun_W, static_cast<float>(view::kSunRadius_rad), samples.Point(2, 3));
    }
    shadow.Set(lane, hits.surfaces[i].p_WOut, to_sun_W, 0.0f, kNever, kBlocks);
  }
  shadow.Block(world_.tree());
  for (int lane = 0; lane < kLanes; ++lane) {
    if (shadow.IsFree(lane)) light[lane] += hits.parts[static_cast<std::size_t>(lane)].sun;
  }
}

// The light around; of the samples of a picture the share for which something near stands in its way gets none.
void Shading::AddSurroundings(const Rays& rays, const Hits& hits, const Square* square, glm::vec3* light) const {
  const bool has_occlusion = square != nullptr && quality_.sample > 0;
  Rays around;
  for (int lane = 0; lane < kLanes && has_occlusion; ++lane) {
    const auto i = static_cast<std::size_t>(lane);
    if (!rays.HasHit(lane)) continue;
    const Samples samples(quality_.sample, square->x + lane % kSide, square->y + lane / kSide);
    const glm::vec3 d_W = AboveSurface(hits.surfaces[i].smooth_n_W, samples.Point(5, 7));
    around.Set(lane, hits.surfaces[i].p_WOut, d_W, 0.0f, kHides_m, kBlocks);
  }
  around.Block(world_.tree());
  for (int lane = 0; lane < kLanes; ++lane) {
    if (!rays.HasHit(lane) || (has_occlusion && !around.IsFree(lane))) continue;
    light[lane] += hits.parts[static_cast<std::size_t>(lane)].ambient;
  }
}

void Shading::AddMirrored(const Rays& rays, const Hits& hits, int depth, glm::vec3* light) const {
  std::array<float, kLanes> sharp{};  // how much of the mirror image is followed
  for (int lane = 0; lane < kLanes && depth == 0 && quality_.mirrors != tiles::Mirrors::kNone; ++lane) {
    const auto i = static_cast<std::size_t>(lane);
    if (!rays.HasHit(lane)) continue;
    // Of the sharper one of lacquer and what is below it.
    const float share = 1.0f - glm::smoothstep(kSharp, kBlurred, std::sqrt(hits.parts[i].lobe_rad));
    // A bump may mirror what is below its own surface.
    const bool leaves = glm::dot(hits.parts[i].mirror_W, hits.surfaces[i].smooth_n_W) > 0.0f;
    if (leaves && share * Most(hits.parts[i].mirror) > kLeastShare) sharp[i] = share;
  }
  // Whose ray stands for a lane's: its own, or a neighbour's on the same surface.
  std::array<int, kLanes> by{};
  Rays mirror;
  for (const auto& quad : kQuads) {
    for (const int lane : quad) {
      const auto i = static_cast<std::size_t>(lane);
      by[i] = lane;
      if (sharp[i] == 0.0f) continue;
      for (const int other : quad) {
        if (quality_.mirrors != tiles::Mirrors::kHalf || other == lane) break;
        const auto k = static_cast<std::size_t>(other);
        const bool is_same = mirror.IsSet(other) && rays.HaveSameHit(lane, other) &&
                             glm::dot(hits.surfaces[i].n_W, hits.surfaces[k].n_W) > kSameNormal;
        if (!is_same) continue;
        by[i] = other;
        break;
      }
      if (by[i] == lane) mirror.Set(lane, hits.surfaces[i].p_WOut, hits.parts[i].mirror_W, 0.0f, kNever, kDrawn);
    }
  }
  mirror.Meet(world_.tree(), RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  std::array<glm::vec3, kLanes> image{};
  if (mirror.HasAny()) Follow(mirror, hits.far_m, depth + 1, nullptr, image.data());
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto i = static_cast<std::size_t>(lane);
    if (!rays.HasHit(lane) || hits.parts[i].mirror == glm::vec3(0.0f)) continue;
    const bool has_image = sharp[i] > 0.0f && mirror.HasHit(by[i]);
    glm::vec3 around(0.0f);
    if (!has_image || sharp[i] < 1.0f) {
      around = lighting_.Environment(hits.parts[i].mirror_W, hits.parts[i].lobe_rad);
    }
    if (has_image) around = glm::mix(around, image[static_cast<std::size_t>(by[i])], sharp[i]);
    light[lane] += hits.parts[i].mirror * around;
  }
}

// Light that comes through glass: along the ray that Snell's law bends, n sin a = n' sin a'. Where it cannot leave the
// glass it is mirrored inside; of what leaves it the surface keeps the share that Fresnel's formula, as Schlick has it,
// says. Behind the last pane is the light around: stars are too far away to be seen through a bend.
void Shading::AddThrough(const Rays& rays, const Hits& hits, int depth, glm::vec3* light) const {
  Rays through;
  std::array<glm::vec3, kLanes> share{};
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto i = static_cast<std::size_t>(lane);
    if (!rays.HasHit(lane) || hits.surfaces[i].transmission <= 0.0f) continue;
    const Surface& surface = hits.surfaces[i];
    share[i] = surface.is_back ? glm::vec3(1.0f) : hits.parts[i].through;
    if (Most(share[i]) <= kLeastShare || depth >= kMostDepth) continue;
    const glm::vec3& n = surface.smooth_n_W;
    const float eta = surface.is_back ? surface.ior : 1.0f / surface.ior;
    const glm::vec3 bent_W = glm::refract(-surface.v_W, n, eta);
    if (bent_W == glm::vec3(0.0f)) {
      through.Set(lane, surface.p_WOut, glm::reflect(-surface.v_W, n), 0.0f, kNever, kDrawn);
      continue;
    }
    if (surface.is_back) {
      const float f0 = (surface.ior - 1.0f) * (surface.ior - 1.0f) / ((surface.ior + 1.0f) * (surface.ior + 1.0f));
      const float w = 1.0f - std::abs(glm::dot(bent_W, n));
      share[i] *= (1.0f - f0) * (1.0f - w * w * w * w * w);
    }
    through.Set(lane, 2.0f * surface.p_W - surface.p_WOut, bent_W, 0.0f, kNever, kDrawn);
  }
  if (!through.HasAny()) return;
  through.Meet(world_.tree(), RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  std::array<glm::vec3, kLanes> behind{};
  Follow(through, hits.far_m, depth + 1, nullptr, behind.data());
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto i = static_cast<std::size_t>(lane);
    if (!through.IsSet(lane)) continue;
    light[lane] += share[i] * (through.HasHit(lane) ? behind[i] : lighting_.Environment(through.Along(lane), 0.0f));
  }
}

}  // namespace raytrace
