#pragma once

namespace visual_node {

// Colours and figures without a source are chosen by eye.

// --- The Earth's surface in its own frame, once for each tile of the cube maps: the ground's colour, clouds in alpha,
// and the lights of towns.
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
layout(binding = 0) uniform sampler2D u_land;    // reflectance times share of land, share of land
layout(binding = 1) uniform sampler2D u_lights;
layout(binding = 2) uniform sampler2D u_clouds;
in vec3 v_direction;
layout(location = 0) out vec4 o_color;
layout(location = 1) out float o_lights;

void main() {
  vec3 n = normalize(v_direction);
  vec2 place = vec2(atan(n.y, n.x) / 6.2831853 + 0.5, 0.5 - asin(clamp(n.z, -1.0, 1.0)) / 3.14159265);
  vec4 land = textureLod(u_land, place, 0.0);
  vec3 ground = land.rgb + (1.0 - land.a) * vec3(0.006, 0.014, 0.040);
  o_color = vec4(sqrt(ground), sqrt(textureLod(u_clouds, place, 0.0).r));  // finer steps in the dark
  o_lights = textureLod(u_lights, place, 0.0).r;
}
)";

// --- Everything far away, at the far plane, each only in the part of the picture that it needs: stars, the sun, the
// Moon, and the Earth with its air in front of them. With a ball's centre e at distance 1 and its radius r, a ray d
// hits at the distance d.e - sqrt(r^2 - m^2), where m = sqrt(1 - (d.e)^2) is its distance from the centre. Stars are
// brighter than they are beside a sunlit satellite, where none would be seen; among each other they are right. So is
// the sun's disc, in the other direction: it is 46000 times brighter than a wall.
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
constexpr const char* kStarsFragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D u_stars;  // cd/m2
out vec4 o_color;
const float kStarLight = 14.0;  // of the film, for 1 cd/m2
void main() {
  o_color = vec4(vec3(0.0012, 0.0018, 0.0036) + kStarLight * texelFetch(u_stars, ivec2(gl_FragCoord.xy), 0).rgb, 0.0);
}
)";
// --- The sun with its glare, added to that.
constexpr const char* kSunFragment = R"(#version 450 core
layout(location = 3) uniform vec3 u_sun_direction_W;
layout(location = 9) uniform vec3 u_glare;  // of the sun, in the camera
in vec3 v_direction;
out vec4 o_color;
const float kSunRadius_rad = 0.00465;
void main() {
  float to_sun = length(normalize(v_direction) - u_sun_direction_W);
  o_color = vec4(vec3(12.0) * smoothstep(1.1, 0.9, to_sun / kSunRadius_rad) + u_glare * exp(-to_sun / 0.02), 0.0);
}
)";
// --- The Moon, in front of both.
constexpr const char* kMoonFragment = R"(#version 450 core
layout(location = 3) uniform vec3 u_sun_direction_W;
layout(location = 4) uniform vec4 u_moon_W;  // direction to its centre, sine of its angular radius
in vec3 v_direction;
out vec4 o_color;
void main() {
  vec3 d = normalize(v_direction);
  vec3 e = u_moon_W.xyz;
  float along = dot(d, e);
  float miss = length(d - along * e);
  if (along <= 0.0 || miss >= u_moon_W.w) discard;
  vec3 n = (d * (along - sqrt(u_moon_W.w * u_moon_W.w - miss * miss)) - e) / u_moon_W.w;
  o_color = vec4(vec3(0.75, 0.73, 0.70) * sqrt(max(dot(n, u_sun_direction_W), 0.0)), 1.0);
}
)";

// --- The Earth through its air (space/atmosphere/from_space.hpp), in radii of its ground. What is behind it is kept as
// far as the air lets it through, for each colour: the second output of a dual-source blend. Only in the rectangle
// around the disc.
//
// Water mirrors the sun's disc in waves whose slopes are normally distributed [Cox and Munk 1954]: for a slope of
// tangent t and the variance s = 0.003 + 0.00512 wind, here 7 m/s,
//   L = E F exp(-t^2 / s) / (4 pi s cos(view) cos(slope)^4).
constexpr const char* kEarthAirFragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D u_scattering;  // columns: nu and mu_s, rows: of the ground, of the sky
layout(binding = 1) uniform samplerCube u_earth;
layout(binding = 2) uniform sampler2D u_through;     // rows: ground, sky
layout(binding = 3) uniform sampler2D u_ground_light;
layout(binding = 4) uniform samplerCube u_lights;
layout(binding = 5) uniform sampler3D u_fine;  // fine_structure.hpp
layout(location = 1) uniform vec4 u_earth_W;  // direction to its centre, sine of its angular radius
layout(location = 2) uniform mat3 u_R_EW;
layout(location = 3) uniform vec3 u_sun_direction_W;
layout(location = 5) uniform vec4 u_shell;    // top, horizon from there, lowest sun's cosine, its distance (mapping.hpp)
layout(location = 6) uniform vec4 u_mie;      // colour against molecules, mean cosine of the deflection
layout(location = 7) uniform vec3 u_sun;      // radiance of a white wall that faces it
layout(location = 8) uniform vec3 u_samples;  // of mu, nu and mu_s
layout(location = 9) uniform vec3 u_glare;
in vec3 v_direction;
layout(location = 0, index = 0) out vec4 o_color;
layout(location = 0, index = 1) out vec4 o_keep;

const float kPi = 3.14159265;
const float kWaves = 0.039;
// The brightest towns send about 0.1 cd/m2 up; a candela counts as much as a star's (kStarLight). Lamps are lit between
// sunset and the end of civil twilight, with the sun 6 degrees below the horizon: its sine is -0.105. Chosen by eye:
// their colour, and what thick clouds let through.
const vec3 kTownLight = 1.4 * vec3(1.0, 0.72, 0.40);
const float kCivilTwilight = 0.105;
const float kCloudsHide = 0.85;

vec3 Glint(vec3 d, vec3 n, float water) {
  vec3 h = normalize(u_sun_direction_W - d);
  float slope = max(dot(h, n), 0.05);
  float view = max(dot(n, -d), 0.08);
  float slope2 = slope * slope;
  float w = 1.0 - max(dot(h, -d), 0.0);
  float fresnel = 0.02 + 0.98 * w * w * w * w * w;
  float share = fresnel * exp((1.0 - 1.0 / slope2) / kWaves) / (4.0 * kPi * kWaves * view * slope2 * slope2);
  return vec3(water * share * kPi);
}

void main() {
  vec3 d = normalize(v_direction);
  vec3 e = u_earth_W.xyz;
  float distance = 1.0 / u_earth_W.w;
  float top = u_shell.x;
  float horizon = u_shell.y;
  float least = top - 1.0;
  float cosine = dot(d, e);
  float miss = length(d - cosine * e) * distance;
  if (cosine <= 0.0 || miss >= top) discard;
  float along = cosine * distance;
  float in_air = sqrt(top * top - miss * miss);  // half of the ray's way between the top and the top again
  float in_ground = sqrt(max(1.0 - miss * miss, 0.0));
  bool is_ground = miss < 1.0;
  float x = is_ground ? (in_air - in_ground - least) / (horizon - least) : in_air / horizon;

  vec3 n_top = (d * (along - in_air) - e * distance) / top;
  float mu_s = dot(n_top, u_sun_direction_W);
  float nu = dot(d, u_sun_direction_W);
  float a = (sqrt(mu_s * mu_s + horizon * horizon) - mu_s - least) / (horizon - least);
  float column = (max(1.0 - a / u_shell.w, 0.0) / (1.0 + a) * (u_samples.z - 1.0) + 0.5) / (u_samples.z * u_samples.y);
  float half_rows = 0.5 * u_samples.x;
  float row = (x * (half_rows - 1.0) + 0.5 + (is_ground ? 0.0 : half_rows)) / u_samples.x;
  float turn = 0.5 * (nu + 1.0) * (u_samples.y - 1.0);
  float first = min(floor(turn), u_samples.y - 2.0);
  vec4 air = mix(texture(u_scattering, vec2(first / u_samples.y + column, row)),
                 texture(u_scattering, vec2((first + 1.0) / u_samples.y + column, row)), turn - first);
  float g = u_mie.w;
  float q = 1.0 + g * g - 2.0 * g * nu;
  float rayleigh = 3.0 / (16.0 * kPi) * (1.0 + nu * nu);
  float mie = 3.0 / (8.0 * kPi) * (1.0 - g * g) * (1.0 + nu * nu) / ((2.0 + g * g) * q * sqrt(q));
  vec3 light = kPi * u_sun * air.rgb * (rayleigh + u_mie.rgb * (mie * air.a / max(air.r, 1e-9)));
  vec3 through = texture(u_through, vec2(x * (255.0 / 256.0) + 0.5 / 256.0, is_ground ? 0.25 : 0.75)).rgb;

  vec3 n = normalize(d * (along - in_ground) - e * distance);
  float height = dot(n, u_sun_direction_W);
  float at = (height - u_shell.z) / (1.0 - u_shell.z);
  vec3 sunlit = texture(u_ground_light, vec2(at * (511.0 / 512.0) + 0.5 / 512.0, 0.5)).rgb;
  // Finer than the maps: coasts and clouds are displaced by up to 10 km, land is mottled, and what the map has of clouds
  // between none and all is broken up. The cube of noise is 230 km wide.
  vec3 place_E = u_R_EW * n;
  vec2 fine = texture(u_fine, 27.7 * place_E).rg - 0.5;
  vec4 ground = texture(u_earth, place_E + 0.0026 * vec3(fine.g, fine.r, -fine.g));
  ground.a = clamp(ground.a + 4.5 * fine.r * ground.a * (1.0 - ground.a), 0.0, 1.0);
  // Nothing else down there is bluer than red.
  float water = smoothstep(0.04, 0.12, ground.b - ground.r) * (1.0 - ground.a);
  // Clouds are bluish against the air in front of them, as half of it is below their tops.
  vec3 soil = ground.rgb * ground.rgb * (1.0 + 0.35 * (1.0 - water) * fine.g);
  vec3 albedo = mix(soil, vec3(0.80, 0.86, 0.96), ground.a);
  vec3 glint = Glint(d, n, water) / max(height, 0.15);  // sunlit has the cosine in it
  vec3 surface = through * u_sun * sunlit * (albedo + glint) + vec3(0.0012, 0.0018, 0.0036);
  if (height < 0.0) {
    float lit = smoothstep(0.0, kCivilTwilight, -height) * texture(u_lights, place_E).r;
    surface += through * kTownLight * (lit * (1.0 - kCloudsHide * ground.a));
  }

  float open = is_ground ? 0.0 : dot(through, vec3(1.0 / 3.0));
  o_color = vec4(light + (is_ground ? surface : vec3(0.0)), 1.0 - open);
  o_color.rgb += u_glare * exp(-length(d - u_sun_direction_W) / 0.02) * (1.0 - open);
  o_keep = vec4(is_ground ? vec3(0.0) : through, open);
}
)";

}  // namespace visual_node
