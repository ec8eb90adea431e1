#include "raytrace/tracer.hpp"

#include <algorithm>

#include "raytrace/rays.hpp"
#include "raytrace/sampling.hpp"
#include "raytrace/shading.hpp"

namespace raytrace {
namespace {

// Calls visit(x, y, lane, ...) for the squares of a tile, with rays through the pixels' centres. Their length is such
// that a ray's parameter is the depth.
// `shift_px`: from there.
template <class Visit>
void EachSquare(const Eye& eye, const Tile& tile, const glm::vec2& shift_px, unsigned mask, const World& world,
                Visit&& visit) {
  const NoDenormals quick;
  const glm::vec2 pixel = eye.pixel();
  for (int top = 0; top < tile.height; top += kSide) {
    for (int left = 0; left < tile.width; left += kSide) {
      Rays rays;
      for (int lane = 0; lane < kLanes; ++lane) {
        const int x = left + lane % kSide, y = top + lane / kSide;
        if (x >= tile.width || y >= tile.height) continue;
        const glm::vec2 at_px = glm::vec2(tile.x + x, tile.y + y) + 0.5f + shift_px;
        const glm::vec3 d_E(eye.left + at_px.x * pixel.x, eye.top - at_px.y * pixel.y, -1.0f);
        rays.Set(lane, eye.p_W, eye.R_WE * d_E, Tracer::kNear_m, Tracer::kFar_m, mask);
      }
      rays.Meet(world.tree(), RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
      visit(left, top, rays);
    }
  }
}

// The sample's place within the pixels, the same in all of them, so that edges are smooth alike.
glm::vec2 ShiftOf(std::uint32_t sample) {
  if (sample == 0) return glm::vec2(0.0f);
  return glm::vec2(Samples::Inverse(sample, 2), Samples::Inverse(sample, 3)) - 0.5f;
}

}  // namespace

Eye Eye::Of(const view::Frustum& frustum, int width, int height) {
  return {glm::vec3(frustum.eye_W),
          glm::mat3(frustum.R_WE),
          static_cast<float>(frustum.left),
          static_cast<float>(frustum.right),
          static_cast<float>(frustum.bottom),
          static_cast<float>(frustum.top),
          width,
          height};
}

Eye Eye::Of(const scene::Camera& placed, int width, int height) {
  return Of(view::FrustumOf(placed, static_cast<double>(width) / height), width, height);
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

LitTile Tracer::Draw(const Eye& eye, const Tile& tile, const tiles::Quality& quality) const {
  LitTile lit{tile, {tile.width, tile.height, 3}, {tile.width, tile.height}};
  const glm::vec2 pixel = eye.pixel();
  const Shading shading(*world_, lighting_, std::max(pixel.x, pixel.y), quality);
  EachSquare(eye, tile, ShiftOf(quality.sample), kDrawn, *world_, [&](int left, int top, const Rays& rays) {
    if (!rays.HasAnyHit()) return;
    glm::vec3 light[kLanes] = {};
    shading.FollowFromEye(rays, tile.x + left, tile.y + top, light);
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
  EachSquare(eye, tile, glm::vec2(0.0f), kVisible, *world_, [&](int left, int top, const Rays& rays) {
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
