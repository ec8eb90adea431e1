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
layout(location = 1) uniform vec2 u_size_px;  // of the disc, and at most at the distance 1
out vec3 v_color;
void main() {
  v_color = a_color;
  gl_Position = u_clip_P * vec4(a_p_P, 1.0);
  gl_PointSize = max(1.0, min(u_size_px.x, u_size_px.y / max(gl_Position.w, 1e-3)));
  // Nearer by 0.3 % of the distance, so that a point on a surface is before it: 2 kNear_m 0.3 % (renderer.hpp).
  gl_Position.z -= 6e-5;
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

// --- Cubes and spheres of a frame P: each a square that faces the eye and is as large as the sphere around it; a
// fragment finds where its ray meets the body.
constexpr const char* kGrainVertex = R"(#version 450 core
layout(location = 0) in vec4 a_p_P_size;  // a cube's size is 1
layout(location = 0) uniform mat4 u_clip_P;
layout(location = 1) uniform vec3 u_eye_P;
layout(location = 3) uniform vec2 u_scale_reach;  // radius or half edge of a size of 1; of the sphere around, over that
out vec3 v_p_P;
flat out vec3 v_centre_P;
flat out float v_radius;
void main() {
  v_centre_P = a_p_P_size.xyz;
  v_radius = a_p_P_size.w * u_scale_reach.x;
  float around = v_radius * u_scale_reach.y;
  vec3 to_eye = u_eye_P - v_centre_P;
  float d = length(to_eye);
  if (d < 1.01 * around) {  // the eye is inside
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  vec3 z = to_eye / d;
  vec3 x = normalize(cross(abs(z.x) < 0.8 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0), z));
  float reach = around * d / sqrt((d - around) * (d + around));
  vec2 corner = vec2((gl_VertexID & 1) == 0 ? -reach : reach, gl_VertexID < 2 ? -reach : reach);
  v_p_P = v_centre_P + corner.x * x + corner.y * cross(z, x);
  gl_Position = u_clip_P * vec4(v_p_P, 1.0);
}
)";
constexpr const char* kCubeFragment = R"(#version 450 core
layout(location = 0) uniform mat4 u_clip_P;
layout(location = 1) uniform vec3 u_eye_P;
layout(location = 2) uniform vec4 u_color;
in vec3 v_p_P;
flat in vec3 v_centre_P;
flat in float v_radius;
out vec4 o_color;
void main() {
  vec3 ray = normalize(v_p_P - u_eye_P), from = u_eye_P - v_centre_P;
  vec3 inverse = 1.0 / (ray + vec3(equal(ray, vec3(0.0))) * 1e-20);
  vec3 near = (-sign(inverse) * v_radius - from) * inverse, far = (sign(inverse) * v_radius - from) * inverse;
  float t = max(near.x, max(near.y, near.z));
  if (t > min(far.x, min(far.y, far.z))) discard;
  vec3 n = vec3(greaterThanEqual(near, vec3(t)));
  vec3 at = abs(from + t * ray) / v_radius;  // 1 on a face
  vec3 in_face = mix(at, vec3(0.0), n);
  float edge = max(in_face.x, max(in_face.y, in_face.z));
  float shade = dot(n, vec3(0.72, 0.55, 0.95)) * (edge > 0.88 ? 0.72 : 1.0);
  o_color = vec4(u_color.rgb * shade, u_color.a);
  vec4 clip = u_clip_P * vec4(v_centre_P + from + t * ray, 1.0);
  gl_FragDepth = 0.5 * clip.z / clip.w + 0.5;
}
)";
constexpr const char* kSphereFragment = R"(#version 450 core
layout(location = 0) uniform mat4 u_clip_P;
layout(location = 1) uniform vec3 u_eye_P;
layout(location = 2) uniform vec4 u_color;
in vec3 v_p_P;
flat in vec3 v_centre_P;
flat in float v_radius;
out vec4 o_color;
void main() {
  vec3 ray = normalize(v_p_P - u_eye_P), from = u_eye_P - v_centre_P;
  float b = dot(from, ray);
  vec3 miss = from - b * ray;
  float h = v_radius * v_radius - dot(miss, miss);
  if (h < 0.0) discard;
  vec3 n = (from + (-b - sqrt(h)) * ray) / v_radius;
  float rim = 1.0 + dot(n, ray);
  o_color = vec4(u_color.rgb * (0.55 + 0.45 * (1.0 - rim)), u_color.a * (0.12 + 0.88 * rim * rim * rim));
  vec4 clip = u_clip_P * vec4(v_centre_P + v_radius * n, 1.0);
  gl_FragDepth = 0.5 * clip.z / clip.w + 0.5;
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
