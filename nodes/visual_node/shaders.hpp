#pragma once

namespace visual_node {

// GLSL 4.5. Locations are explicit, so no names are resolved at run time. Light is linear (film.hpp says in which
// unit). Strengths of lights and materials without a source are chosen by eye on the scenarios' pictures.

// --- Depth as seen from the sun.
constexpr const char* kShadowVertex = R"(#version 450 core
layout(location = 0) in vec3 a_p_M;
layout(location = 0) uniform mat4 u_X_WM;
layout(location = 1) uniform mat4 u_sun_W;
void main() { gl_Position = u_sun_W * (u_X_WM * vec4(a_p_M, 1.0)); }
)";
constexpr const char* kShadowFragment = R"(#version 450 core
void main() {}
)";

// --- Surfaces: glTF metallic-roughness.
constexpr const char* kSurfaceVertex = R"(#version 450 core
layout(location = 0) in vec3 a_p_M;
layout(location = 1) in vec3 a_n_M;
layout(location = 0) uniform mat4 u_X_WM;
layout(location = 1) uniform mat4 u_clip_W;
layout(location = 2) uniform mat4 u_sun_W;
layout(location = 3) uniform float u_shadow_offset_m;
out vec3 v_p_W;
out vec3 v_n_W;
out vec3 v_sun;
void main() {
  vec4 p_W = u_X_WM * vec4(a_p_M, 1.0);
  v_p_W = p_W.xyz;
  v_n_W = mat3(u_X_WM) * a_n_M;
  // The map is sampled 1.5 texels outside the surface, against self-shadowing (normal offset).
  vec4 sun = u_sun_W * vec4(p_W.xyz + u_shadow_offset_m * v_n_W, 1.0);
  v_sun = 0.5 * sun.xyz + 0.5;
  gl_Position = u_clip_W * p_W;
}
)";
// Reflectance for light direction l, view direction v, half vector h, normal n and a = roughness^2, as in appendix B of
// the glTF 2.0 specification:
//   f = (1 - metallic) base / pi (1 - F) + F D V,
//   D = a^2 / (pi ((n.h)^2 (a^2 - 1) + 1)^2)                      GGX distribution [Walter et al. 2007],
//   V = 0.5 / lerp(2 n.l n.v, n.l + n.v, a)                       Smith visibility [Hammon 2017],
//   F = F0 + (1 - F0) (1 - h.v)^5                                 Fresnel factor [Schlick 1994].
// Environment light by Karis' analytic approximation of the split sum [Karis 2014]. The environment itself is analytic:
// black sky, Earth, and soft lights so that surfaces in the sun's shadow remain readable.
constexpr const char* kSurfaceFragment = R"(#version 450 core
layout(location = 4) uniform vec4 u_base_metallic;
layout(location = 5) uniform vec4 u_emissive_roughness;
layout(location = 6) uniform vec3 u_eye_W;
layout(location = 7) uniform vec3 u_sun_direction_W;
layout(location = 8) uniform vec4 u_lamp_position[4];  // xyz W, w: reach [m]
layout(location = 12) uniform vec3 u_lamp_color[4];
layout(location = 16) uniform int u_num_lamps;
layout(location = 17) uniform vec3 u_earth_direction_W;
layout(binding = 0) uniform sampler2DShadow u_shadow;
in vec3 v_p_W;
in vec3 v_n_W;
in vec3 v_sun;
out vec4 o_color;

vec3 Environment(vec3 d, float blur) {
  float earth = smoothstep(-0.2 - blur, 0.5 + blur, dot(d, u_earth_direction_W));
  float below = 1.0 - smoothstep(-0.7 - blur, 0.3 + blur, d.z);
  float key = smoothstep(0.45 - 0.7 * blur, 0.95, dot(d, normalize(vec3(0.25, -0.65, 0.72))));
  float rim = smoothstep(0.60 - 0.7 * blur, 0.98, dot(d, normalize(vec3(-0.75, 0.25, 0.60))));
  float strength = 1.0 - 0.70 * blur;
  return vec3(0.034, 0.039, 0.050) + strength * (earth * vec3(0.10, 0.17, 0.28) + below * vec3(0.07, 0.09, 0.12) +
                                                 key * vec3(0.74, 0.71, 0.66) + rim * vec3(0.34, 0.36, 0.40));
}

void main() {
  vec3 base = u_base_metallic.rgb;
  float metallic = u_base_metallic.a;
  float roughness = clamp(u_emissive_roughness.a, 0.06, 1.0);
  vec3 n = normalize(gl_FrontFacing ? v_n_W : -v_n_W);
  vec3 v = normalize(u_eye_W - v_p_W);
  vec3 l = u_sun_direction_W;
  vec3 h = normalize(l + v);
  float nv = max(dot(n, v), 1e-3);
  float nl = max(dot(n, l), 0.0);
  float nh = max(dot(n, h), 0.0);
  float hv = max(dot(h, v), 0.0);
  vec3 f0 = mix(vec3(0.04), base, metallic);
  vec3 diffuse = base * (1.0 - metallic);

  float a = roughness * roughness;
  float q = nh * nh * (a * a - 1.0) + 1.0;
  float distribution = a * a / (3.14159265 * q * q);
  float visibility = 0.5 / mix(2.0 * nl * nv, nl + nv, a);
  float w = 1.0 - hv;
  float w2 = w * w;
  vec3 fresnel = f0 + (1.0 - f0) * (w2 * w2 * w);
  float lit = nl * texture(u_shadow, v_sun);
  vec3 color = vec3(2.95, 2.84, 2.66) * lit *
               (diffuse * 0.31830989 * (1.0 - fresnel) + fresnel * min(distribution * visibility, 24.0));

  vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float a004 = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
  vec2 ab = vec2(-1.04, 1.04) * a004 + r.zw;
  color += Environment(reflect(-v, n), roughness) * (f0 * ab.x + ab.y);
  color += Environment(n, 1.0) * diffuse + diffuse * (0.07 * nv);

  for (int i = 0; i < u_num_lamps; ++i) {
    vec3 to = u_lamp_position[i].xyz - v_p_W;
    float d = length(to) / u_lamp_position[i].w;
    float fall = 1.0 / (1.0 + d * d);
    color += u_lamp_color[i] * (0.9 * fall * fall * max(0.25 + 0.75 * dot(n, to) / max(length(to), 1e-4), 0.0)) *
             (0.25 + 0.75 * base);
  }
  o_color = vec4(color + 1.5 * u_emissive_roughness.rgb, 1.0);
}
)";

// --- A lamp's glow: a quad facing the eye, blended additively.
constexpr const char* kGlowVertex = R"(#version 450 core
layout(location = 0) uniform mat4 u_clip_W;
layout(location = 1) uniform vec3 u_centre_W;
layout(location = 2) uniform vec3 u_right_W;  // half width
layout(location = 3) uniform vec3 u_up_W;
out vec2 v_uv;
void main() {
  v_uv = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  gl_Position = u_clip_W * vec4(u_centre_W + v_uv.x * u_right_W + v_uv.y * u_up_W, 1.0);
}
)";
constexpr const char* kGlowFragment = R"(#version 450 core
layout(location = 4) uniform vec3 u_color;
in vec2 v_uv;
out vec4 o_color;
void main() {
  float d = max(0.0, 1.0 - dot(v_uv, v_uv));
  o_color = vec4(u_color * (0.25 * d * d * d), 0.0);
}
)";

// --- Overlay bodies (arrows): one colour, lit from the eye, the same in every exposure.
constexpr const char* kOverlayVertex = R"(#version 450 core
layout(location = 0) in vec3 a_p_M;
layout(location = 1) in vec3 a_n_M;
layout(location = 0) uniform mat4 u_A_WM;  // rotation and scale
layout(location = 1) uniform mat4 u_clip_W;
out vec3 v_p_W;
out vec3 v_n_W;
void main() {
  vec4 p_W = u_A_WM * vec4(a_p_M, 1.0);
  v_p_W = p_W.xyz;
  // The columns are orthogonal, so the inverse transpose has the columns divided by their squared lengths.
  mat3 m = mat3(u_A_WM);
  v_n_W = m[0] * (a_n_M.x / dot(m[0], m[0])) + m[1] * (a_n_M.y / dot(m[1], m[1])) + m[2] * (a_n_M.z / dot(m[2], m[2]));
  gl_Position = u_clip_W * p_W;
}
)";
constexpr const char* kOverlayFragment = R"(#version 450 core
layout(location = 2) uniform vec4 u_color;
layout(location = 3) uniform vec3 u_eye_W;
layout(location = 4) uniform float u_exposure;
in vec3 v_p_W;
in vec3 v_n_W;
out vec4 o_color;
void main() {
  float facing = abs(dot(normalize(v_n_W), normalize(u_eye_W - v_p_W)));
  o_color = vec4(u_color.rgb * ((0.35 + 0.65 * facing) / u_exposure), u_color.a);
}
)";

// --- Text and the panels behind it, in pixels from the top left corner.
constexpr const char* kTextVertex = R"(#version 450 core
layout(location = 0) in vec4 a_px_uv;
layout(location = 1) in vec4 a_color;
layout(location = 0) uniform vec2 u_size_px;
out vec2 v_uv;
out vec4 v_color;
void main() {
  v_uv = a_px_uv.zw;
  v_color = a_color;
  vec2 p = 2.0 * a_px_uv.xy / u_size_px - 1.0;
  gl_Position = vec4(p.x, -p.y, 0.0, 1.0);
}
)";
constexpr const char* kTextFragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D u_coverage;
in vec2 v_uv;
in vec4 v_color;
out vec4 o_color;
void main() {
  float coverage = v_uv.x < 0.0 ? 1.0 : texture(u_coverage, v_uv).r;  // negative: a panel
  o_color = vec4(v_color.rgb, v_color.a * coverage);
}
)";

}  // namespace visual_node
