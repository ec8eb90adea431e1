#pragma once

namespace visual_node {

// --- A triangle that covers the picture.
constexpr const char* kFilmVertex = R"(#version 450 core
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)";

// --- The tone curve and sRGB of view/appearance/tone_curve.hpp. Instead of the power 1 / 2.4, for which a software
// renderer takes a logarithm and an exponential, roots that it has an instruction for: fitted for the least largest
// error between 0.0031308 and 1, which is 0.011 of a code of eight bits.
constexpr const char* kToneCurve = R"(
vec3 ToneCurve(vec3 light) {
  float least = min(light.r, min(light.g, light.b));
  light -= least < 0.08 ? least - 6.25 * least * least : 0.04;
  float peak = max(light.r, max(light.g, light.b));
  float new_peak = 1.0 - 0.0576 / (max(peak, 0.76) - 0.52);
  float white = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
  return peak < 0.76 ? light : mix(light * (new_peak / peak), vec3(new_peak), white);
}
vec3 EncodeSrgb(vec3 linear) {
  vec3 root2 = sqrt(linear);
  vec3 root4 = sqrt(root2);
  vec3 encoded = 0.64236326 * root2 + 0.71211306 * root4 - 0.33687100 * sqrt(root4) - 0.01756217 * linear;
  return mix(12.92 * linear, encoded, greaterThan(linear, vec3(0.0031308)));
}
)";

// --- Exposure, tone curve and sRGB. Alpha: the luma that the next pass compares; 0 where nothing is to be smoothed.
// MakeProgram gets the tone curve in front of this.
constexpr const char* kDevelopFragment = R"(
layout(binding = 0) uniform sampler2D u_light;
layout(location = 0) uniform float u_exposure;
out vec4 o_color;
void main() {
  vec4 light = texelFetch(u_light, ivec2(gl_FragCoord.xy), 0);
  vec3 color = EncodeSrgb(clamp(ToneCurve(u_exposure * light.rgb), 0.0, 1.0));
  o_color = vec4(color, dot(color, vec3(0.299, 0.587, 0.114)) * min(light.a, 1.0));
}
)";

// --- Smooths edges: fast approximate anti-aliasing [Lottes 2009], with the lumas of a pixel's four diagonal
// neighbours. Where they differ, the picture is averaged along the edge, which is at right angles to the luma's
// gradient: over two points, or over four if these do not reach beyond the edge. It is computed at every pixel: a
// software renderer executes both sides of an `if`, and a loop once, even when no pixel wants to.
constexpr const char* kSmoothFragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D u_picture;
layout(location = 0) uniform vec2 u_texel;  // one pixel, in texture coordinates
out vec4 o_color;
const float kLeastContrast = 0.04;   // of the lumas
const float kContrast = 0.125;       // of the brightest of them
const float kReach_px = 8.0;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec2 uv = gl_FragCoord.xy * u_texel;
  vec4 centre = texelFetch(u_picture, at, 0);
  ivec2 last = textureSize(u_picture, 0) - 1;
  float nw = texelFetch(u_picture, clamp(at + ivec2(-1, 1), ivec2(0), last), 0).a;
  float ne = texelFetch(u_picture, clamp(at + ivec2(1, 1), ivec2(0), last), 0).a;
  float sw = texelFetch(u_picture, clamp(at + ivec2(-1, -1), ivec2(0), last), 0).a;
  float se = texelFetch(u_picture, clamp(at + ivec2(1, -1), ivec2(0), last), 0).a;
  float low = min(min(min(nw, ne), min(sw, se)), centre.a);
  float high = max(max(max(nw, ne), max(sw, se)), centre.a);
  bool is_edge = high - low > max(kLeastContrast, kContrast * high);
  vec2 along = vec2(nw + ne - sw - se, nw + sw - ne - se);
  float flat_part = max(0.03125 * (nw + ne + sw + se), 0.0078125);
  along = clamp(along / (min(abs(along.x), abs(along.y)) + flat_part), -kReach_px, kReach_px) * u_texel;
  vec4 two = 0.5 * (textureLod(u_picture, uv - along / 6.0, 0.0) + textureLod(u_picture, uv + along / 6.0, 0.0));
  vec4 ends = textureLod(u_picture, uv - 0.5 * along, 0.0) + textureLod(u_picture, uv + 0.5 * along, 0.0);
  vec4 four = 0.5 * two + 0.25 * ends;
  vec3 smooth_color = four.a < low || four.a > high ? two.rgb : four.rgb;
  vec3 color = is_edge ? smooth_color : centre.rgb;
  o_color = vec4(color, 1.0);
}
)";

// --- The light meter: each of its few pixels sums the logarithms of 16 samples of its part of the picture.
constexpr const char* kMeterFragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D u_light;
layout(location = 0) uniform vec2 u_cell_px;
out vec2 o_sum;  // of log2 luminance, number
void main() {
  vec2 corner = floor(gl_FragCoord.xy) * u_cell_px;
  o_sum = vec2(0.0);
  for (int i = 0; i < 16; ++i) {
    vec4 light = texelFetch(u_light, ivec2(corner + (vec2(i & 3, i >> 2) + 0.5) * 0.25 * u_cell_px), 0);
    float counts = step(0.5, light.a);
    o_sum += counts * vec2(log2(max(dot(light.rgb, vec3(0.2126, 0.7152, 0.0722)), 1e-3)), 1.0);
  }
}
)";

}  // namespace visual_node
