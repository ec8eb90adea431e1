#pragma once

namespace visual_node {

// --- Surfaces: glTF metallic-roughness. The painter puts the version, the variant, kIrradiance and the light panels
// (the constants kPanel0, kPanelEdge0, ...: direction in W and strength; cosines of the outer and the inner edge) in
// front:
//   FOIL   wrinkled foil, with a direction in which it was rolled,
//   SOFT   the sun's penumbra, for views near enough to show it,
//   BASE_MAP, SURFACE_MAP, NORMAL_MAP, GLOW_MAP   textures of colour; of occlusion, roughness and metal; of the normal;
//          of what it emits,
//   COAT   clear lacquer or glass over it,
//   LAMPS  a lamp is near enough to light it.

// What a matt white surface with the normal n reflects of the light around (view::Irradiance): the same for both sides
// of a surface, and opposite.
constexpr const char* kIrradiance = R"(
layout(location = 26) uniform vec3 u_irradiance[9];
vec3 EvenIrradiance(vec3 n) {
  return u_irradiance[0] + n.x * n.y * u_irradiance[4] + n.y * n.z * u_irradiance[5] +
         (3.0 * n.z * n.z - 1.0) * u_irradiance[6] + n.x * n.z * u_irradiance[7] +
         (n.x * n.x - n.y * n.y) * u_irradiance[8];
}
vec3 OddIrradiance(vec3 n) { return n.y * u_irradiance[1] + n.z * u_irradiance[2] + n.x * u_irradiance[3]; }
)";

// What follows from a mesh's vertices is computed there: a software renderer has far fewer of them than pixels, and
// reading a uniform at a pixel costs it as much as five multiplications.
constexpr const char* kSurfaceVertex = R"(
layout(location = 0) in vec3 a_p_M;
layout(location = 1) in vec3 a_n_M;
layout(location = 2) in vec3 a_rest_p;  // before a sheet was bent
layout(location = 3) in vec3 a_rest_n;
layout(location = 4) in vec2 a_uv;
layout(location = 0) uniform mat4 u_X_EM;  // E: at the eye, with the axes of W
layout(location = 1) uniform mat4 u_clip_M;
layout(location = 2) uniform mat4 u_sun_M;
layout(location = 3) uniform float u_shadow_offset_m;
out vec3 v_p_E;
out vec3 v_n_W;
out vec3 v_sun;
#ifndef NORMAL_MAP
out vec3 v_even;
out vec3 v_odd;
#endif
#ifdef FOIL
out vec3 v_rest_p;
out vec3 v_rest_n;
#endif
#if defined(BASE_MAP) || defined(SURFACE_MAP) || defined(NORMAL_MAP) || defined(GLOW_MAP)
out vec2 v_uv;
#endif
void main() {
#if defined(BASE_MAP) || defined(SURFACE_MAP) || defined(NORMAL_MAP) || defined(GLOW_MAP)
  v_uv = a_uv;
#endif
  v_p_E = (u_X_EM * vec4(a_p_M, 1.0)).xyz;
  vec3 n = mat3(u_X_EM) * a_n_M;
  v_n_W = n;
#ifndef NORMAL_MAP
  v_even = EvenIrradiance(n);
  v_odd = OddIrradiance(n);
#endif
#ifdef FOIL
  v_rest_p = a_rest_p;
  v_rest_n = a_rest_n;
#endif
  // The map is sampled 1.5 texels outside the surface, against self-shadowing (normal offset).
  v_sun = 0.5 * (u_sun_M * vec4(a_p_M + u_shadow_offset_m * a_n_M, 1.0)).xyz + 0.5;
  gl_Position = u_clip_M * vec4(a_p_M, 1.0);
}
)";

// Reflectance for light direction l, view direction v, half vector h, normal n and a = roughness^2, as in appendix B of
// the glTF 2.0 specification:
//   D = a^2 / (pi ((n.h)^2 (a^2 - 1) + 1)^2)                      GGX distribution [Walter et al. 2007],
//   V = 0.5 / lerp(2 n.l n.v, n.l + n.v, a)                       Smith visibility [Hammon 2017],
//   F = F0 + (1 - F0) (1 - h.v)^5                                 Fresnel factor [Schlick 1994].
// With the split sum (x, y) of split_sum.hpp a surface mirrors E = F0 x + y of the light from everywhere once, and
// E (1 - x - y) M / (1 - (1 - x - y) M) more often, M = F0 + (1 - F0) / 21 [Fdez-Aguera 2019]; a matt ground gets the
// rest. Between metal and dielectric these shares are mixed, as the specification mixes both. In the light of the sun
// D V F is larger by 1 + F0 (1 / (x + y) - 1) for what is mirrored more often [Turquin 2019]. That factor and the matt
// ground's share are of n.v alone, so no energy is lost towards any eye; without them light and view may be swapped.
//
// Lacquer (KHR_materials_clearcoat) mirrors as a dielectric of its own roughness does, on the surface without bumps;
// what it lets through, 1 less what it mirrors of the light from everywhere, is all that the surface below sends to the
// eye.
//
// Foil: D stretched along the direction of rolling [Burley 2012]; the wrinkles that are smaller than a pixel widen it.
constexpr const char* kSurfaceFragment = R"(
layout(location = 0) uniform mat4 u_X_EM;
layout(location = 4) uniform vec4 u_base_metallic;
layout(location = 5) uniform vec4 u_emissive_roughness;
layout(location = 7) uniform vec3 u_sun_direction_W;
#ifdef LAMPS
layout(location = 8) uniform vec4 u_lamp_position[4];  // xyz E, w: reach [m]
layout(location = 12) uniform vec3 u_lamp_color[4];
layout(location = 16) uniform int u_num_lamps;
const float kLampReaches = 7.0;
#endif
layout(location = 17) uniform vec4 u_earth_W;  // direction to its centre, sine of its angular radius
layout(location = 18) uniform vec3 u_sun;
layout(location = 19) uniform vec3 u_earth;
layout(location = 20) uniform vec3 u_panels;
layout(location = 21) uniform vec3 u_everywhere;
#ifdef SURFACE_MAP
layout(location = 35) uniform float u_occlusion;  // how much the texture's red counts
#endif
#ifdef COAT
layout(location = 36) uniform vec2 u_coat;  // share, roughness
#endif
layout(binding = 0) uniform sampler2DShadow u_shadow;
layout(binding = 1) uniform sampler2D u_split_sum;
layout(binding = 2) uniform sampler2D u_shadow_depth;
layout(binding = 3) uniform sampler2D u_wrinkles;  // tilts, sum of their squares
layout(binding = 4) uniform sampler2D u_base_map;
layout(binding = 5) uniform sampler2D u_surface_map;
layout(binding = 6) uniform sampler2D u_normal_map;
layout(binding = 7) uniform sampler2D u_glow_map;
in vec3 v_p_E;
in vec3 v_n_W;
in vec3 v_sun;
#ifndef NORMAL_MAP
in vec3 v_even;
in vec3 v_odd;
#endif
#ifdef FOIL
in vec3 v_rest_p;
in vec3 v_rest_n;
#endif
#if defined(BASE_MAP) || defined(SURFACE_MAP) || defined(NORMAL_MAP) || defined(GLOW_MAP)
in vec2 v_uv;
#endif
out vec4 o_color;

// EnvironmentLight::Radiance from the direction d, seen by a lobe of half-angle a [rad]; dl: d.l.
vec3 Environment(vec3 d, float dl, float a) {
  float widen = 0.7 * a;
  float panels = kPanel0.w * smoothstep(kPanelEdge0.x - widen, kPanelEdge0.y, dot(d, kPanel0.xyz)) +
                 kPanel1.w * smoothstep(kPanelEdge1.x - widen, kPanelEdge1.y, dot(d, kPanel1.xyz));
  vec3 e = u_earth_W.xyz;
  float sine = u_earth_W.w;
  float along = dot(d, e);
  float rest = sine * sine - (1.0 - along * along);
  float edge = sqrt(1.0 - sine * sine);
  float soft = sine * a + 0.002;
  // Of the sun over the place n = (d (along - sqrt(rest)) - e) / sine of the Earth: n.l.
  float day = (dl * (max(along, edge) - sqrt(max(rest, 0.0))) - dot(e, u_sun_direction_W)) / sine;
  day = 0.5 * (day + sqrt(day * day + 0.1 * a * a));
  return u_everywhere + u_panels * (panels * (1.0 - widen)) +
         u_earth * (day * smoothstep(edge - soft, edge + soft, along));
}

// The share of the sun that is seen. Its half-angle is 0.00465, and the map is as deep as it is wide, so a caster at
// distance t in front has a penumbra of half-width 0.00465 t in the map's own unit [Fernando 2005].
float Sunlit(vec3 s, float slope) {
#ifdef SOFT
  const float kSun = 0.00465;
  float near = 0.75 / float(textureSize(u_shadow_depth, 0).x);
  float reach = max(kSun * s.z, near);
  vec4 hits = vec4(0.0);
  vec4 depths = vec4(0.0);
  for (int i = 0; i < 4; ++i) {
    vec2 at = s.xy + reach * (vec2(i & 1, i >> 1) * 1.4 - 0.7);
    vec4 d = textureGather(u_shadow_depth, at);
    vec4 is_hit = step(d, vec4(s.z - slope * reach));
    hits += is_hit;
    depths += is_hit * d;
  }
  float count = dot(hits, vec4(1.0));
  float lit = count > 0.0 ? 0.0 : 1.0;
  int is_between = int(count > 0.0 && count < 16.0);
  for (int pass = 0; pass < is_between; ++pass) {
    float width = max(kSun * (s.z - dot(depths, vec4(1.0)) / count), near);
    float sum = 0.0;
    for (int i = 0; i < 16; ++i) {
      float r = sqrt((float(i) + 0.5) / 16.0) * width;
      float turn = 2.39996323 * float(i);
      sum += texture(u_shadow, vec3(s.xy + r * vec2(cos(turn), sin(turn)), s.z - slope * r));
    }
    lit = sum / 16.0;
  }
  return lit;
#else
  return texture(u_shadow, s);
#endif
}

void main() {
  float side = gl_FrontFacing ? 1.0 : -1.0;
  vec3 n = normalize(side * v_n_W);
  vec3 l = u_sun_direction_W;
  vec3 smooth_n = n;  // without bumps and wrinkles
  float facing = dot(n, l);
  float slope = min(sqrt(max(1.0 - facing * facing, 0.0)) / max(facing, 0.2), 3.0);
  float lit = facing > 0.0 ? Sunlit(v_sun, slope) : 0.0;

  vec3 base = u_base_metallic.rgb;
  float metallic = u_base_metallic.a;
  float roughness = clamp(u_emissive_roughness.a, 0.06, 1.0);
  vec3 v = normalize(-v_p_E);
#ifdef BASE_MAP
  base *= texture(u_base_map, v_uv).rgb;
#endif
#ifdef SURFACE_MAP
  vec3 surface = texture(u_surface_map, v_uv).rgb;
  roughness = clamp(u_emissive_roughness.a * surface.g, 0.06, 1.0);
  metallic *= surface.b;
  float open = mix(1.0, surface.r, u_occlusion);
#else
  const float open = 1.0;
#endif
  float a = roughness * roughness;

#ifdef NORMAL_MAP
  // The texture's axes on the surface, from how place and texture coordinates change between pixels [Schueler 2006].
  // The texture's y points upwards, v downwards.
  vec3 across_x = cross(dFdy(v_p_E), n);
  vec3 across_y = cross(n, dFdx(v_p_E));
  vec2 uv_x = dFdx(v_uv);
  vec2 uv_y = dFdy(v_uv);
  vec3 t_u = across_x * uv_x.x + across_y * uv_y.x;
  vec3 t_v = across_x * uv_x.y + across_y * uv_y.y;
  float shrink = inversesqrt(max(max(dot(t_u, t_u), dot(t_v, t_v)), 1e-30));
  vec3 bump = texture(u_normal_map, v_uv).rgb * (255.0 / 127.0) - (128.0 / 127.0);
  n = normalize(shrink * (bump.x * t_u - bump.y * t_v) + bump.z * n);
#endif

#ifdef FOIL
  vec3 facing_M = abs(v_rest_n);
  bool is_x = facing_M.x > facing_M.y && facing_M.x > facing_M.z;
  bool is_y = !is_x && facing_M.y > facing_M.z;
  vec2 place = is_x ? v_rest_p.yz : (is_y ? v_rest_p.xz : v_rest_p.xy);
  vec3 along = is_x ? u_X_EM[1].xyz : u_X_EM[0].xyz;
  vec3 across = is_x || is_y ? u_X_EM[2].xyz : u_X_EM[1].xyz;
  along -= n * dot(n, along);
  across -= n * dot(n, across);
  vec3 tilt = texture(u_wrinkles, 4.0 * place).xyz * vec3(2.0, 2.0, 1.0) - vec3(1.0, 1.0, 0.0);  // a tile of 0.25 m
  n = normalize(n - tilt.x * along - tilt.y * across);
  a = sqrt(min(a * a + max(tilt.z - dot(tilt.xy, tilt.xy), 0.0), 1.0));
  roughness = sqrt(a);
#endif

  // Without h = (l + v) / |l + v|, as |l + v|^2 = 2 + 2 l.v.
  float n_v = dot(n, v);
  float n_l = dot(n, l);
  float l_v = dot(l, v);
  float shorten = inversesqrt(max(2.0 + 2.0 * l_v, 1e-7));
  float nv = clamp(n_v, 1e-3, 1.0);
  float nl = max(n_l, 0.0);
  float nh = clamp((n_l + n_v) * shorten, 0.0, 1.0);
  float hv = min((1.0 + l_v) * shorten, 1.0);
  vec3 f0 = mix(vec3(0.04), base, metallic);

  vec2 split = texture(u_split_sum, vec2(nv, roughness) * (31.0 / 32.0) + 0.5 / 32.0).xy;
  float lost = 1.0 - split.x - split.y;
  vec3 once = f0 * split.x + split.y;
  float once_ground = 0.04 * split.x + split.y;
  float again_ground = once_ground * lost * 0.0857 / (1.0 - lost * 0.0857);
  vec3 mean = base + (1.0 - base) / 21.0;
  vec3 again_metal = (base * split.x + split.y) * lost * mean / (1.0 - lost * mean);
  vec3 again = mix(vec3(again_ground), again_metal, metallic);
  vec3 matt = base * ((1.0 - metallic) * (1.0 - once_ground - again_ground));

#ifdef FOIL
  const float kRolled = 0.6;
  vec3 t = normalize(along - n * dot(n, along));
  vec3 h = (l + v) * shorten;
  float ht = dot(h, t) / (a * (1.0 + kRolled));
  float hb = dot(h, cross(n, t)) / (a * (1.0 - kRolled));
  float q = ht * ht + hb * hb + nh * nh;
  float distribution = 1.0 / (3.14159265 * a * a * (1.0 - kRolled * kRolled) * q * q);
#else
  float q = nh * nh * (a * a - 1.0) + 1.0;
  float distribution = a * a / (3.14159265 * q * q);
#endif
  float visibility = 0.5 / mix(2.0 * nl * nv, nl + nv, a);
  float w = 1.0 - hv;
  float w2 = w * w;
  vec3 fresnel = f0 + (1.0 - f0) * (w2 * w2 * w);
  // The sun's image in a mirror would be 40000 times brighter than a wall; it is bounded against flicker.
  vec3 mirrored = fresnel * min(distribution * visibility, 24.0) * (1.0 + f0 * (lost / (1.0 - lost)));
  vec3 color = u_sun * (lit * nl) * (matt * 0.31830989 + mirrored);

#ifdef NORMAL_MAP
  vec3 irradiance = max(EvenIrradiance(n) + OddIrradiance(n), 0.0);
#else
  vec3 irradiance = max(v_even + side * v_odd, 0.0);
#endif
  vec3 mirrored_way = 2.0 * n_v * n - v;
  color += open * (Environment(mirrored_way, 2.0 * n_v * n_l - l_v, a) * once + irradiance * (again + matt));

#ifdef LAMPS
  for (int i = 0; i < u_num_lamps; ++i) {
    vec3 to = u_lamp_position[i].xyz - v_p_E;
    float reach = u_lamp_position[i].w;
    float d2 = dot(to, to);
    for (int k = int(d2 < kLampReaches * kLampReaches * reach * reach); k > 0; --k) {
      float fall = 1.0 / (1.0 + d2 / (reach * reach));
      color += u_lamp_color[i] * (0.9 * fall * fall * max(0.25 + 0.75 * dot(n, to) * inversesqrt(max(d2, 1e-8)), 0.0)) *
               (0.25 + 0.75 * base);
    }
  }
#endif
  vec3 glow = u_emissive_roughness.rgb;
#ifdef GLOW_MAP
  glow *= texture(u_glow_map, v_uv).rgb;
#endif
  color += glow;

#ifdef COAT
  float coat_roughness = max(u_coat.y, 0.06);
  float ac = coat_roughness * coat_roughness;
  float smooth_v = dot(smooth_n, v);
  float nvc = clamp(smooth_v, 1e-3, 1.0);
  float nlc = max(facing, 0.0);
  float nhc = clamp((facing + smooth_v) * shorten, 0.0, 1.0);
  vec2 split_c = texture(u_split_sum, vec2(nvc, coat_roughness) * (31.0 / 32.0) + 0.5 / 32.0).xy;
  float lost_c = 1.0 - split_c.x - split_c.y;
  float once_c = 0.04 * split_c.x + split_c.y;
  float again_c = once_c * lost_c * 0.0857 / (1.0 - lost_c * 0.0857);
  float qc = nhc * nhc * (ac * ac - 1.0) + 1.0;
  float mirrored_c = (0.04 + 0.96 * w2 * w2 * w) * (1.0 + 0.04 * (lost_c / (1.0 - lost_c))) *
                     min(ac * ac / (3.14159265 * qc * qc) * 0.5 / mix(2.0 * nlc * nvc, nlc + nvc, ac), 24.0);
  vec3 around_c = Environment(2.0 * smooth_v * smooth_n - v, 2.0 * smooth_v * facing - l_v, ac);
  color = color * (1.0 - u_coat.x * (once_c + again_c)) +
          u_coat.x * (u_sun * (lit * nlc * mirrored_c) + open * (around_c * once_c + irradiance * again_c));
#endif
  o_color = vec4(color, 1.0);
}
)";

}  // namespace visual_node
