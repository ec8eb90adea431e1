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
