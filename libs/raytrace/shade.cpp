#include "raytrace/shade.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "view/appearance/split_sum.hpp"

namespace raytrace {
namespace {

constexpr float kPi = 3.14159265f;

float Distribution(const Surface& s, const glm::vec3& h, float nh, float a) {
  if (!s.is_foil) {
    const float q = nh * nh * (a * a - 1.0f) + 1.0f;
    return a * a / (kPi * q * q);
  }
  constexpr float kRolled = 0.6f;
  const glm::vec3 t = glm::normalize(s.along_W - s.n_W * glm::dot(s.n_W, s.along_W));
  const float ht = glm::dot(h, t) / (a * (1.0f + kRolled));
  const float hb = glm::dot(h, glm::cross(s.n_W, t)) / (a * (1.0f - kRolled));
  const float q = ht * ht + hb * hb + nh * nh;
  return 1.0f / (kPi * a * a * (1.0f - kRolled * kRolled) * q * q);
}

// What is mirrored once, and more often, of white light from everywhere, by a dielectric; and how much less than all an
// ideal mirror would have mirrored once.
struct Dielectric {
  float once, again, lost;
  explicit Dielectric(const glm::vec2& split) : once(0.04f * split.x + split.y), lost(1.0f - split.x - split.y) {
    again = once * lost * 0.0857f / (1.0f - lost * 0.0857f);
  }
};

}  // namespace

Lighting::Lighting() : split_sum_(view::SplitSumTable()) {}

void Lighting::Set(const view::EnvironmentLight& light, std::vector<Lamp> lamps) {
  if (!(light == light_)) irradiance_ = view::Irradiance(light);
  light_ = light;
  lamps_ = std::move(lamps);
}

glm::vec3 Lighting::Environment(const glm::vec3& d, float a) const {
  glm::vec3 sum = light_.everywhere;
  const float widen = 0.7f * a;
  for (const view::LightPanel& panel : view::kPanels) {
    sum += light_.panels * (panel.strength * (1.0f - 0.7f * a) *
                            glm::smoothstep(panel.outer - widen, panel.inner, glm::dot(d, panel.direction_W)));
  }
  const glm::vec3& e = light_.earth_direction_W;
  const float sine = light_.earth_sine;
  const float along = glm::dot(d, e);
  const float rest = sine * sine - (1.0f - along * along);
  const float edge = std::sqrt(1.0f - sine * sine);
  const float soft = sine * a + 0.002f;
  const glm::vec3 n = (d * (std::max(along, edge) - std::sqrt(std::max(rest, 0.0f))) - e) / sine;
  float day = glm::dot(n, light_.sun_direction_W);
  day = 0.5f * (day + std::sqrt(day * day + 0.1f * a * a));
  return sum + light_.earth * (day * glm::smoothstep(edge - soft, edge + soft, along));
}

glm::vec3 Lighting::Irradiance(const glm::vec3& n) const {
  const auto& c = irradiance_;
  return glm::max(c[0] + n.y * c[1] + n.z * c[2] + n.x * c[3] + n.x * n.y * c[4] + n.y * n.z * c[5] +
                      (3.0f * n.z * n.z - 1.0f) * c[6] + n.x * n.z * c[7] + (n.x * n.x - n.y * n.y) * c[8],
                  0.0f);
}

glm::vec2 Lighting::SplitSum(float nv, float roughness) const {
  constexpr int kLast = view::kSplitSumSize - 1;
  const float x = nv * kLast, y = roughness * kLast;
  const int column = std::min(static_cast<int>(x), kLast - 1), row = std::min(static_cast<int>(y), kLast - 1);
  const glm::vec2* at = &split_sum_[static_cast<std::size_t>(row * view::kSplitSumSize + column)];
  const float s = x - static_cast<float>(column), t = y - static_cast<float>(row);
  return glm::mix(glm::mix(at[0], at[1], s), glm::mix(at[view::kSplitSumSize], at[view::kSplitSumSize + 1], s), t);
}

Lighting::Parts Lighting::Reflect(const Surface& s) const {
  Parts parts;
  const float a = s.roughness * s.roughness;
  const glm::vec3& n = s.n_W;
  const glm::vec3& l = light_.sun_direction_W;
  const float nv = glm::clamp(glm::dot(n, s.v_W), 1e-3f, 1.0f);
  const float nl = std::max(glm::dot(n, l), 0.0f);
  const glm::vec3 f0 = glm::mix(glm::vec3(0.04f), s.base, s.metallic);

  const glm::vec2 split = SplitSum(nv, s.roughness);
  const Dielectric ground(split);
  const float lost = ground.lost;
  const glm::vec3 once = f0 * split.x + split.y;
  const glm::vec3 mean = s.base + (1.0f - s.base) / 21.0f;
  const glm::vec3 again_metal = (s.base * split.x + split.y) * lost * mean / (1.0f - lost * mean);
  const glm::vec3 again = glm::mix(glm::vec3(ground.again), again_metal, s.metallic);
  const glm::vec3 within = s.base * ((1.0f - s.metallic) * (1.0f - ground.once - ground.again));
  const glm::vec3 matt = (1.0f - s.transmission) * within;

  if (nl > 0.0f && glm::dot(s.smooth_n_W, l) > 0.0f) {
    const glm::vec3 h = glm::normalize(l + s.v_W);
    const float nh = std::max(glm::dot(n, h), 0.0f), hv = std::max(glm::dot(h, s.v_W), 0.0f);
    const float visibility = 0.5f / glm::mix(2.0f * nl * nv, nl + nv, a);
    const float w = 1.0f - hv, w2 = w * w;
    const glm::vec3 fresnel = f0 + (1.0f - f0) * (w2 * w2 * w);
    const glm::vec3 mirrored =
        fresnel * std::min(Distribution(s, h, nh, a) * visibility, 24.0f) * (1.0f + f0 * (lost / (1.0f - lost)));
    parts.sun = light_.sun * nl * (matt / kPi + mirrored);
  }
  parts.mirror = s.open * once;
  parts.mirror_W = glm::reflect(-s.v_W, n);
  parts.lobe_rad = a;
  parts.ambient = s.open * Irradiance(n) * (again + matt);
  parts.through = s.transmission * within;
  parts.rest = s.emissive;
  for (const Lamp& lamp : lamps_) {
    const glm::vec3 to = lamp.p_W - s.p_W;
    const float far_m = glm::length(to), d = far_m / lamp.reach_m, fall = 1.0f / (1.0f + d * d);
    const float facing = std::max(0.25f + 0.75f * glm::dot(n, to) / std::max(far_m, 1e-4f), 0.0f);
    parts.rest += lamp.color * (0.9f * fall * fall * facing) * (0.25f + 0.75f * s.base);
  }
  if (s.coat > 0.0f && !s.is_foil) Coat(s, &parts);
  return parts;
}

// Of lacquer and what is below it only one mirror image is followed, the sharper one; the light around stands for the
// other.
void Lighting::Coat(const Surface& s, Parts* parts) const {
  const float roughness = std::max(s.coat_roughness, 0.06f), a = roughness * roughness;
  const glm::vec3& n = s.smooth_n_W;
  const glm::vec3& l = light_.sun_direction_W;
  const float nv = glm::clamp(glm::dot(n, s.v_W), 1e-3f, 1.0f), nl = std::max(glm::dot(n, l), 0.0f);
  const Dielectric mirrors(SplitSum(nv, roughness));
  const float kept = 1.0f - s.coat * (mirrors.once + mirrors.again);
  parts->sun *= kept;
  parts->mirror *= kept;
  parts->rest *= kept;
  parts->through *= kept;
  parts->ambient = kept * parts->ambient + s.coat * s.open * mirrors.again * Irradiance(s.n_W);
  if (nl > 0.0f) {
    const glm::vec3 h = glm::normalize(l + s.v_W);
    const float nh = std::max(glm::dot(n, h), 0.0f), w = 1.0f - std::max(glm::dot(h, s.v_W), 0.0f);
    const float q = nh * nh * (a * a - 1.0f) + 1.0f, distribution = a * a / (kPi * q * q);
    const float visibility = 0.5f / glm::mix(2.0f * nl * nv, nl + nv, a);
    const float fresnel = 0.04f + 0.96f * w * w * w * w * w;
    parts->sun += light_.sun * (s.coat * nl * fresnel * std::min(distribution * visibility, 24.0f) *
                                (1.0f + 0.04f * (mirrors.lost / (1.0f - mirrors.lost))));
  }
  const glm::vec3 mirror(s.open * s.coat * mirrors.once), mirror_W = glm::reflect(-s.v_W, n);
  if (a < parts->lobe_rad) {
    parts->rest += parts->mirror * Environment(parts->mirror_W, parts->lobe_rad);
    parts->mirror = mirror;
    parts->mirror_W = mirror_W;
    parts->lobe_rad = a;
  } else {
    parts->rest += mirror * Environment(mirror_W, a);
  }
}

}  // namespace raytrace
