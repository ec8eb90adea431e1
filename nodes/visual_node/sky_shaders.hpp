#pragma once

namespace visual_node {

// --- The Earth, once per face of the cube map: a ball of angular radius 0.45 rad with clouds from value noise (six
// octaves). With the ball's centre e at distance 1 and radius r = sin 0.45, a ray d hits at the distance
// d.e - sqrt(r^2 - m^2), where m = sqrt(1 - (d.e)^2) is its distance from the centre. The air's brightness falls
// exponentially with the height (m - r) / r above the limb. Colours and figures are chosen by eye.
constexpr const char* kEarthVertex = R"(#version 450 core
layout(location = 0) uniform vec3 u_centre;
layout(location = 1) uniform vec3 u_right;
layout(location = 2) uniform vec3 u_down;
out vec3 v_direction;
void main() {
  vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  v_direction = u_centre + p.x * u_right + p.y * u_down;
  gl_Position = vec4(p, 0.0, 1.0);
}
)";
constexpr const char* kEarthFragment = R"(#version 450 core
layout(location = 3) uniform vec3 u_sun_direction_W;
in vec3 v_direction;
out vec4 o_color;

float Hash(vec3 p) {
  uvec3 q = uvec3(ivec3(p)) * uvec3(1597334673u, 3812015801u, 2798796415u);
  uint h = (q.x ^ q.y ^ q.z) * 1597334673u;
  return float(h >> 8) * (1.0 / 16777216.0);
}
float Noise(vec3 p) {
  vec3 i = floor(p);
  vec3 f = p - i;
  f = f * f * (3.0 - 2.0 * f);
  vec2 e = vec2(0.0, 1.0);
  return mix(mix(mix(Hash(i + e.xxx), Hash(i + e.yxx), f.x), mix(Hash(i + e.xyx), Hash(i + e.yyx), f.x), f.y),
             mix(mix(Hash(i + e.xxy), Hash(i + e.yxy), f.x), mix(Hash(i + e.xyy), Hash(i + e.yyy), f.x), f.y), f.z);
}
float Layers(vec3 p) {
  float sum = 0.0;
  float weight = 0.5;
  for (int i = 0; i < 6; ++i) {
    sum += weight * Noise(p);
    p = 2.03 * p + vec3(17.1, 31.7, 11.3);
    weight *= 0.5;
  }
  return sum;
}

void main() {
  vec3 d = normalize(v_direction);
  const vec3 e = normalize(vec3(-0.82, 0.27, -0.50));  // from the eye to the Earth's centre
  const float radius = sin(0.45);                      // with the centre at distance 1
  float along = dot(d, e);
  float miss = sqrt(max(1.0 - along * along, 0.0));
  vec3 color = vec3(0.0012, 0.0018, 0.0036);
  if (along > 0.0 && miss < radius) {
    vec3 n = (d * (along - sqrt(radius * radius - miss * miss)) - e) / radius;
    float day = smoothstep(-0.10, 0.85, dot(n, u_sun_direction_W));
    vec3 warp = vec3(Noise(6.0 * n + 40.0), Noise(6.0 * n + 60.0), Noise(6.0 * n + 80.0));
    float cloud = smoothstep(0.46, 0.72, Layers(vec3(7.0, 7.0, 13.0) * n + 1.6 * warp + 100.0));
    float land = smoothstep(0.53, 0.58, Layers(3.2 * n + 150.0));
    vec3 ground = mix(vec3(0.010, 0.045, 0.125), vec3(0.065, 0.075, 0.040), land);
    vec3 surface = mix(ground, vec3(0.46, 0.49, 0.53), 0.85 * cloud);
    float rim = 1.0 - max(dot(n, -d), 0.0);
    surface = mix(surface, vec3(0.16, 0.34, 0.66), 0.18 + 0.62 * rim * rim * rim);
    color += 0.42 * day * surface;
  } else if (along > 0.0) {
    float height = (miss - radius) / radius;
    vec3 n = normalize(d * along - e);
    float day = smoothstep(-0.15, 0.7, dot(n, u_sun_direction_W));
    color += day * (vec3(0.20, 0.44, 0.90) * 0.55 * exp(-height / 0.012) + vec3(0.05, 0.13, 0.32) * 0.30 * exp(-height / 0.05));
  }
  o_color = vec4(pow(clamp(color, 0.0, 1.0), vec3(1.0 / 2.2)), 1.0);
}
)";

// --- Background: the cube map at the far plane.
constexpr const char* kSkyVertex = R"(#version 450 core
layout(location = 0) uniform mat4 u_sky_clip;  // direction from clip space
out vec3 v_direction;
void main() {
  vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  vec4 far = u_sky_clip * vec4(p, 1.0, 1.0);
  v_direction = far.xyz / far.w;
  gl_Position = vec4(p, 1.0, 1.0);
}
)";
constexpr const char* kSkyFragment = R"(#version 450 core
layout(binding = 0) uniform samplerCube u_sky;
in vec3 v_direction;
out vec4 o_color;
void main() { o_color = texture(u_sky, v_direction); }
)";

// --- Stars: points at infinity.
constexpr const char* kStarVertex = R"(#version 450 core
layout(location = 0) in vec4 a_direction_brightness;
layout(location = 0) uniform mat4 u_clip_sky;
layout(location = 1) uniform float u_size_px;
out float v_brightness;
void main() {
  vec4 p = u_clip_sky * vec4(a_direction_brightness.xyz, 1.0);
  gl_Position = p.xyww;  // on the far plane
  v_brightness = a_direction_brightness.w;
  gl_PointSize = u_size_px * (v_brightness > 0.75 ? 2.0 : 1.0);
}
)";
constexpr const char* kStarFragment = R"(#version 450 core
in float v_brightness;
out vec4 o_color;
void main() { o_color = vec4(vec3(0.92, 0.96, 1.0) * v_brightness, 1.0); }
)";

}  // namespace visual_node
