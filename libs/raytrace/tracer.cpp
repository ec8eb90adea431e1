#include "raytrace/tracer.hpp"

#include <embree3/rtcore.h>
#include <pmmintrin.h>
#include <xmmintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "view/projection.hpp"

namespace raytrace {
namespace {

constexpr int kSide = 4;  // of the square of pixels whose rays go together
constexpr int kLanes = kSide * kSide;
constexpr float kNever = std::numeric_limits<float>::infinity();

// A surface rougher than this spreads its mirror image so far that the surroundings' light stands for it; between both
// the image fades out. By eye.
constexpr float kSharp = 0.15f, kBlurred = 0.35f;
constexpr float kLeastMirror = 0.02f;  // of the light: less is not followed

// Denormal numbers, which only waste time, count as zero while this exists.
class NoDenormals {
 public:
  NoDenormals() : old_(_mm_getcsr()) { _mm_setcsr(old_ | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON); }
  ~NoDenormals() { _mm_setcsr(old_); }
  NoDenormals(const NoDenormals&) = delete;
  NoDenormals& operator=(const NoDenormals&) = delete;

 private:
  unsigned old_;
};

// Sixteen rays.
struct Rays {
  RTCRayHit16 embree;
  alignas(64) std::array<int, kLanes> is_valid{};  // -1: yes, as Embree has it

  void Set(int lane, const glm::vec3& from, const glm::vec3& along, float near, float far, unsigned mask) {
    RTCRay16& ray = embree.ray;
    ray.org_x[lane] = from.x;
    ray.org_y[lane] = from.y;
    ray.org_z[lane] = from.z;
    ray.dir_x[lane] = along.x;
    ray.dir_y[lane] = along.y;
    ray.dir_z[lane] = along.z;
    ray.tnear[lane] = near;
    ray.tfar[lane] = far;
    ray.time[lane] = 0.0f;
    ray.mask[lane] = mask;
    ray.id[lane] = 0;
    ray.flags[lane] = 0;
    embree.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    embree.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    is_valid[static_cast<std::size_t>(lane)] = -1;
  }
  // Lanes without a ray have one that goes nowhere.
  void Clear() {
    for (int lane = 0; lane < kLanes; ++lane) Set(lane, glm::vec3(0.0f), glm::vec3(0, 0, 1), 0.0f, -1.0f, 0);
    is_valid.fill(0);
  }
  [[nodiscard]] bool HasAny() const {
    return std::any_of(is_valid.begin(), is_valid.end(), [](int valid) { return valid != 0; });
  }
  [[nodiscard]] bool HasHit(int lane) const {
    return is_valid[static_cast<std::size_t>(lane)] != 0 && embree.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
  }
  [[nodiscard]] glm::vec3 Along(int lane) const {
    return {embree.ray.dir_x[lane], embree.ray.dir_y[lane], embree.ray.dir_z[lane]};
  }

  void Meet(RTCScene tree, RTCIntersectContextFlags flags) {
    if (!HasAny()) return;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = flags;
    rtcIntersect16(is_valid.data(), tree, &context, &embree);
  }
  // Of each ray whether something is in its way: its tfar is negative then. Not with the flag of coherent rays: with
  // instances and partly valid packets, Embree 3.13.5 does not return.
  void Block(RTCScene tree) {
    if (!HasAny()) return;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded16(is_valid.data(), tree, &context, &embree.ray);
  }
};

World::Place PlaceOf(const Rays& rays, int lane, float pixel_m) {
  const RTCHit16& hit = rays.embree.hit;
  return {hit.instID[0][lane], hit.geomID[lane], hit.primID[lane], hit.u[lane], hit.v[lane], rays.Along(lane), pixel_m};
}

// The light that comes back along rays that have met what they meet. `far_m`: how far the eye is from where they begin;
// `spread`: how much wider a pixel is per metre.
class Shading {
 public:
  Shading(const World& world, const Lighting& lighting, float spread)
      : world_(world), lighting_(lighting), spread_(spread) {}

  void Follow(const Rays& rays, bool has_mirrors, const std::array<float, kLanes>& far_m, glm::vec3* light) const {
    std::array<Lighting::Parts, kLanes> parts;
    std::array<float, kLanes> mirrored{};  // how much of the mirror image is followed
    std::array<float, kLanes> next_far_m{};
    Rays shadow, mirror;
    shadow.Clear();
    mirror.Clear();
    for (int lane = 0; lane < kLanes; ++lane) {
      if (!rays.HasHit(lane)) continue;
      const auto i = static_cast<std::size_t>(lane);
      const float reach_m = far_m[i] + rays.embree.ray.tfar[lane] * glm::length(rays.Along(lane));
      const Surface surface = world_.SurfaceAt(PlaceOf(rays, lane, spread_ * reach_m));
      parts[i] = lighting_.Reflect(surface);
      if (parts[i].sun != glm::vec3(0.0f)) {
        shadow.Set(lane, surface.p_WOut, lighting_.to_sun_W(), 0.0f, kNever, kDrawn);
      }
      const glm::vec3& share = parts[i].mirror;
      const float sharp = 1.0f - glm::smoothstep(kSharp, kBlurred, surface.roughness);
      // A bump may mirror what is below its own surface.
      const bool leaves = glm::dot(parts[i].mirror_W, surface.smooth_n_W) > 0.0f;
      if (has_mirrors && leaves && sharp * std::max(share.r, std::max(share.g, share.b)) > kLeastMirror) {
        mirrored[i] = sharp;
        next_far_m[i] = reach_m;
        mirror.Set(lane, surface.p_WOut, parts[i].mirror_W, 0.0f, kNever, kDrawn);
      }
    }
    shadow.Block(world_.tree());
    mirror.Meet(world_.tree(), RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
    std::array<glm::vec3, kLanes> image{};
    if (mirror.HasAny()) Follow(mirror, false, next_far_m, image.data());
    for (int lane = 0; lane < kLanes; ++lane) {
      if (!rays.HasHit(lane)) continue;
      const auto i = static_cast<std::size_t>(lane);
      glm::vec3 around(0.0f);
      const bool is_whole = mirrored[i] == 1.0f && mirror.HasHit(lane);
      if (!is_whole) around = lighting_.Environment(parts[i].mirror_W, parts[i].lobe_rad);
      if (mirror.HasHit(lane)) around = glm::mix(around, image[i], mirrored[i]);
      light[lane] = parts[i].rest + parts[i].mirror * around;
      const bool is_lit = shadow.is_valid[i] != 0 && shadow.embree.ray.tfar[lane] >= 0.0f;
      if (is_lit) light[lane] += parts[i].sun;
    }
  }

 private:
  const World& world_;
  const Lighting& lighting_;
  float spread_;
};

// Calls visit(x, y, lane, ...) for the squares of a tile, with rays through the pixels' centres. Their length is such
// that a ray's parameter is the depth.
template <class Visit>
void EachSquare(const Eye& eye, const Tile& tile, unsigned mask, const World& world, Visit&& visit) {
  const NoDenormals quick;
  Rays rays;
  for (int top = 0; top < tile.height; top += kSide) {
    for (int left = 0; left < tile.width; left += kSide) {
      rays.Clear();
      for (int lane = 0; lane < kLanes; ++lane) {
        const int x = left + lane % kSide, y = top + lane / kSide;
        if (x >= tile.width || y >= tile.height) continue;
        const glm::vec3 d_E(
            (static_cast<float>(tile.x + x) + 0.5f - 0.5f * static_cast<float>(eye.width)) / eye.focal_px,
            (0.5f * static_cast<float>(eye.height) - static_cast<float>(tile.y + y) - 0.5f) / eye.focal_px, -1.0f);
        rays.Set(lane, eye.p_W, eye.R_WE * d_E, Tracer::kNear_m, Tracer::kFar_m, mask);
      }
      rays.Meet(world.tree(), RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
      visit(left, top, rays);
    }
  }
}

}  // namespace

Eye Eye::Of(const scene::Camera& placed, int width, int height) {
  return {glm::vec3(placed.eye_m), glm::mat3(glm::transpose(glm::dmat3(view::ViewMatrix(placed)))),
          static_cast<float>(0.5 * height / std::tan(0.5 * placed.vertical_fov_rad)), width, height};
}

core::Result<std::unique_ptr<Tracer>> Tracer::Create(const view::Scene& scene, const MeshLoader& load_mesh) {
  std::unique_ptr<Tracer> tracer(new Tracer);
  auto world = World::Create(scene, load_mesh);
  if (!world) return tl::unexpected(world.error());
  tracer->world_ = std::move(*world);
  return tracer;
}

void Tracer::Update(const view::Scene& scene, const view::EnvironmentLight& light) {
  world_->Update(scene);
  lighting_.Set(light, world_->ShiningLamps(scene));
}

LitTile Tracer::Draw(const Eye& eye, const Tile& tile, bool has_mirrors) const {
  LitTile lit{tile, {tile.width, tile.height, 3}, {tile.width, tile.height}};
  const Shading shading(*world_, lighting_, 1.0f / eye.focal_px);
  EachSquare(eye, tile, kDrawn, *world_, [&](int left, int top, const Rays& rays) {
    glm::vec3 light[kLanes] = {};
    shading.Follow(rays, has_mirrors, {}, light);
    for (int lane = 0; lane < kLanes; ++lane) {
      if (!rays.HasHit(lane)) continue;
      const auto at = static_cast<std::size_t>((top + lane / kSide) * tile.width + left + lane % kSide);
      lit.depth_m.values[at] = rays.embree.ray.tfar[lane];
      for (std::size_t k = 0; k < 3; ++k) lit.light.values[3 * at + k] = light[lane][static_cast<int>(k)];
    }
  });
  return lit;
}

ObjectTile Tracer::FindObjects(const Eye& eye, const Tile& tile) const {
  ObjectTile objects{{tile.width, tile.height}, {tile.width, tile.height}};
  EachSquare(eye, tile, kVisible, *world_, [&](int left, int top, const Rays& rays) {
    for (int lane = 0; lane < kLanes; ++lane) {
      if (!rays.HasHit(lane)) continue;
      const auto at = static_cast<std::size_t>((top + lane / kSide) * tile.width + left + lane % kSide);
      objects.ids.values[at] = world_->IdOf(rays.embree.hit.instID[0][lane]);
      objects.depth_m.values[at] = rays.embree.ray.tfar[lane];
    }
  });
  return objects;
}

}  // namespace raytrace
