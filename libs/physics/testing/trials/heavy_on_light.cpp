#include "physics/testing/trials/heavy_on_light.hpp"

#include <algorithm>

#include "physics/testing/trials/build.hpp"

namespace physics::trials {

HeavyOnLight::HeavyOnLight(double ratio, ContactKind kind) {
  constexpr double kHalf = 0.5 * kSide_m;
  const glm::dvec3 size(kSide_m);
  const double heavy_kg = ratio * kLight_kg;
  const int light = AddDynamic(&world_, {{1, 0, 0, 0}, {0, 0, kHalf}}, BoxMass(kLight_kg, size));
  const int heavy = AddDynamic(&world_, {{1, 0, 0, 0}, {0, 0, 3 * kHalf}}, BoxMass(heavy_kg, size));
  lower_ = world_.AddContactPair(light, world_.world_body(), kind).value();
  upper_ = world_.AddContactPair(heavy, light, kind).value();
  core::ContactSet set;
  set.friction = 0.3f;
  std::uint32_t id = 0;
  for (const double x : {-kHalf, kHalf}) {
    for (const double y : {-kHalf, kHalf}) AddPlane(&set, ++id, {x, y, -kHalf}, {x, y, 0}, {0, 0, 1}, 1e12);
  }
  world_.SetContactPlanes(lower_, set);
  for (auto& plane : set.planes) plane.q_G.z = static_cast<float>(kHalf);
  world_.SetContactPlanes(upper_, set);
  world_.SetLoad(heavy, {{0, 0, -kGravity * heavy_kg}, {}});
  world_.SetLoad(light, {{0, 0, -kGravity * kLight_kg}, {}});
  weight_N_ = kGravity * (kLight_kg + heavy_kg);
}

void HeavyOnLight::Step() {
  world_.Step(kDt);
  deepest_m_ = std::max({deepest_m_, -world_.SmallestGap_m(lower_), -world_.SmallestGap_m(upper_)});
}

double HeavyOnLight::ForceRatio() const {
  return world_.contact(lower_).F_So_W.force_N.z / weight_N_;
}

}  // namespace physics::trials
