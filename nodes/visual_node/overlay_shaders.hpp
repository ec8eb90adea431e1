#pragma once

namespace visual_node {

// GLSL 4.5 of what explains a scene. Colours are divided by the exposure, so they look the same in every picture.

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

// --- A ring arrow's arc: a tube of which (part of the sweep, cosine, sine of the angle around it) are given.
constexpr const char* kRingVertex = R"(#version 450 core
layout(location = 0) in vec3 a_u_cos_sin;
layout(location = 0) uniform mat4 u_X_WR;  // the arc begins on x and turns about z
layout(location = 1) uniform mat4 u_clip_W;
layout(location = 5) uniform vec3 u_radius_tube_sweep;
out vec3 v_p_W;
out vec3 v_n_W;
void main() {
  float angle = a_u_cos_sin.x * u_radius_tube_sweep.z;
  vec3 outwards = vec3(cos(angle), sin(angle), 0.0);
  vec3 n = a_u_cos_sin.y * outwards + vec3(0.0, 0.0, a_u_cos_sin.z);
  v_n_W = mat3(u_X_WR) * n;
  v_p_W = (u_X_WR * vec4(u_radius_tube_sweep.x * outwards + u_radius_tube_sweep.y * n, 1.0)).xyz;
  gl_Position = u_clip_W * vec4(v_p_W, 1.0);
}
)";

// --- A segment of a line strip: a rectangle of constant width on the screen. It is cut off behind the eye.
constexpr const char* kLineVertex = R"(#version 450 core
layout(location = 0) in vec3 a_p0_W;
layout(location = 1) in vec3 a_p1_W;
layout(location = 0) uniform mat4 u_clip_W;
layout(location = 1) uniform vec3 u_half_size_width_px;  // of the picture, and of the line's width
const float kNearest = 0.01;
void main() {
  vec4 c0 = u_clip_W * vec4(a_p0_W, 1.0), c1 = u_clip_W * vec4(a_p1_W, 1.0);
  if (max(c0.w, c1.w) < kNearest) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  if (c0.w < kNearest) c0 = mix(c0, c1, (kNearest - c0.w) / (c1.w - c0.w));
  if (c1.w < kNearest) c1 = mix(c1, c0, (kNearest - c1.w) / (c0.w - c1.w));
  vec2 along = (c1.xy / c1.w - c0.xy / c0.w) * u_half_size_width_px.xy;
  along = length(along) > 1e-3 ? normalize(along) : vec2(1.0, 0.0);
  bool is_end = gl_VertexID > 1;
  vec2 across = vec2(-along.y, along.x) * ((gl_VertexID & 1) == 0 ? 1.0 : -1.0);
  vec4 c = is_end ? c1 : c0;
  vec2 offset = u_half_size_width_px.z * (across + (is_end ? along : -along)) / u_half_size_width_px.xy;
  gl_Position = c + vec4(offset * c.w, 0.0, 0.0);
}
)";
constexpr const char* kFlatFragment = R"(#version 450 core
layout(location = 2) uniform vec4 u_color;
out vec4 o_color;
void main() { o_color = u_color; }
)";

// --- Points: discs of constant size on the screen.
constexpr const char* kPointVertex = R"(#version 450 core
layout(location = 0) in vec3 a_p_P;
layout(location = 1) in vec3 a_color;
layout(location = 0) uniform mat4 u_clip_P;
layout(location = 1) uniform float u_size_px;
out vec3 v_color;
void main() {
  v_color = a_color;
  gl_PointSize = u_size_px;
  gl_Position = u_clip_P * vec4(a_p_P, 1.0);
}
)";
constexpr const char* kPointFragment = R"(#version 450 core
layout(location = 2) uniform vec2 u_strength_opacity;
in vec3 v_color;
out vec4 o_color;
void main() {
  vec2 d = 2.0 * gl_PointCoord - 1.0;
  if (dot(d, d) > 1.0) discard;
  o_color = vec4(v_color * u_strength_opacity.x, u_strength_opacity.y);
}
)";

// --- Phantoms. Sums and products do not depend on the order in which surfaces are drawn: with the opacities a_i and
// the colours c_i of what lies on a pixel, its mean colour is sum(a_i c_i) / sum(a_i), and it hides 1 - product(1 -
// a_i).
constexpr const char* kPhantomFragment = R"(#version 450 core
layout(location = 2) uniform vec4 u_color;
layout(location = 3) uniform vec3 u_eye_W;
layout(location = 4) uniform float u_exposure;
in vec3 v_p_W;
in vec3 v_n_W;
layout(location = 0) out vec4 o_sum;
layout(location = 1) out float o_hidden;
void main() {
  float facing = dot(normalize(v_n_W), normalize(u_eye_W - v_p_W));
  if (facing < 0.0) discard;  // the far side
  o_sum = vec4(u_color.rgb * ((0.35 + 0.65 * facing) / u_exposure), 1.0) * u_color.a;
  o_hidden = u_color.a;
}
)";
constexpr const char* kMixFragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D u_sum;
layout(binding = 1) uniform sampler2D u_seen;
out vec4 o_color;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float seen = texelFetch(u_seen, pixel, 0).r;
  if (seen == 1.0) discard;
  vec4 sum = texelFetch(u_sum, pixel, 0);
  o_color = vec4(sum.rgb / max(sum.a, 1e-6), 1.0 - seen);
}
)";

}  // namespace visual_node
