#pragma once

namespace visual_node {

// Colours and figures without a source are chosen by eye.

// --- The Earth's surface in its own frame, once for each tile of the cube map: the ground's colour, and clouds from
// value noise (six octaves) in alpha. Clouds are no weather of any day.
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
layout(binding = 0) uniform sampler2D u_land;
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
  vec3 n = normalize(v_direction);
  vec2 place = vec2(atan(n.y, n.x) / 6.2831853 + 0.5, asin(clamp(n.z, -1.0, 1.0)) / 3.14159265 + 0.5);
  float land = smoothstep(0.3, 0.7, textureLod(u_land, place, 0.0).r);
  vec3 warp = vec3(Noise(6.0 * n + 40.0), Noise(6.0 * n + 60.0), Noise(6.0 * n + 80.0));
  float cloud = smoothstep(0.46, 0.72, Layers(vec3(7.0, 7.0, 13.0) * n + 1.6 * warp + 100.0));
  float north = abs(n.z);
  // Deserts about 25 degrees from the equator, ice near the poles.
  float dry = smoothstep(0.22, 0.36, north) * (1.0 - smoothstep(0.48, 0.62, north)) * smoothstep(0.35, 0.6, warp.x);
  vec3 ground = mix(vec3(0.050, 0.085, 0.030), vec3(0.26, 0.20, 0.11), dry);
  ground = mix(ground, vec3(0.55, 0.58, 0.62), smoothstep(0.90, 0.95, north));
  ground = mix(vec3(0.010, 0.045, 0.125), ground, land);
  o_color = vec4(pow(ground, vec3(1.0 / 2.2)), cloud);
}
)";

// --- Everything far away, at the far plane. With a ball's centre e at distance 1 and its radius r, a ray d hits at the
// distance d.e - sqrt(r^2 - m^2), where m = sqrt(1 - (d.e)^2) is its distance from the centre. The air's brightness
// falls exponentially with the height (m - r) / r above the limb. Stars are brighter than
// they are beside a sunlit satellite, where none would be seen; among each other they are right.
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
layout(binding = 0) uniform sampler2D u_stars;  // cd/m2
layout(binding = 1) uniform samplerCube u_earth;
layout(location = 1) uniform vec4 u_earth_W;  // direction to its centre, sine of its angular radius
layout(location = 2) uniform mat3 u_R_EW;
layout(location = 3) uniform vec3 u_sun_direction_W;
layout(location = 4) uniform vec4 u_moon_W;  // as the Earth
in vec3 v_direction;
out vec4 o_color;

const float kStarLight = 14.0;  // of the film, for 1 cd/m2
const float kSunRadius_rad = 0.00465;

void main() {
  vec3 d = normalize(v_direction);
  vec3 color = vec3(0.0012, 0.0018, 0.0036) + kStarLight * texelFetch(u_stars, ivec2(gl_FragCoord.xy), 0).rgb;
  float is_body = 0.0;

  float to_sun = length(d - u_sun_direction_W);
  color += vec3(1.0, 0.97, 0.92) * (smoothstep(1.1, 0.9, to_sun / kSunRadius_rad) + 0.35 * exp(-to_sun / 0.02));

  vec3 e = u_moon_W.xyz;
  float along = dot(d, e);
  float miss = length(d - along * e);
  if (along > 0.0 && miss < u_moon_W.w) {
    is_body = 1.0;
    vec3 n = (d * (along - sqrt(u_moon_W.w * u_moon_W.w - miss * miss)) - e) / u_moon_W.w;
    color = vec3(0.75, 0.73, 0.70) * sqrt(max(dot(n, u_sun_direction_W), 0.0));
  }

  e = u_earth_W.xyz;
  float radius = u_earth_W.w;
  along = dot(d, e);
  miss = length(d - along * e);
  if (along > 0.0 && miss < radius) {
    is_body = 1.0;
    vec3 n = (d * (along - sqrt(radius * radius - miss * miss)) - e) / radius;
    float day = pow(max(dot(n, u_sun_direction_W), 0.0), 0.6);  // no twilight: dark from the terminator on
    vec4 ground = texture(u_earth, u_R_EW * n);
    vec3 surface = mix(pow(ground.rgb, vec3(2.2)), vec3(0.46, 0.49, 0.53), 0.85 * ground.a);
    float rim = 1.0 - max(dot(n, -d), 0.0);
    surface = mix(surface, vec3(0.16, 0.34, 0.66), 0.10 + 0.70 * rim * rim * rim);
    color = vec3(0.0012, 0.0018, 0.0036) + 0.62 * day * surface;
  } else if (along > 0.0) {
    float height = (miss - radius) / radius;
    vec3 n = normalize(d * along - e);
    float day = smoothstep(-0.15, 0.7, dot(n, u_sun_direction_W));
    color += day * (vec3(0.20, 0.44, 0.90) * 0.55 * exp(-height / 0.012) + vec3(0.05, 0.13, 0.32) * 0.30 * exp(-height / 0.05));
  }
  o_color = vec4(color, is_body);
}
)";

}  // namespace visual_node
