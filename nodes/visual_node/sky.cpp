#include "nodes/visual_node/sky.hpp"

#include <cmath>
#include <cstdint>
#include <glm/gtc/type_ptr.hpp>
#include <vector>

#include "nodes/visual_node/sky_shaders.hpp"

namespace visual_node {
namespace {

// Sizes and numbers are chosen by eye and for the time to start (the Earth is computed per pixel); kGlowRadius follows
// from kEarthFragment.
constexpr int kFace_px = 768;
constexpr int kTile_px = 48;
constexpr int kTiles = kFace_px / kTile_px;
constexpr double kGlowRadius_rad =
    0.61;  // beyond this angle from the Earth's direction its air adds less than 0.5 / 255
constexpr int kStars = 900;
constexpr double kAirRadius_rad = 0.49;  // stars within this angle of the Earth's direction are hidden

// The same direction as in kEarthFragment.
glm::dvec3 EarthDirection() {
  return glm::normalize(glm::dvec3(-0.82, 0.27, -0.50));
}

// The colour that kEarthFragment gives far from the Earth.
glm::vec4 EmptySpace() {
  return {glm::pow(glm::vec3(0.0012f, 0.0018f, 0.0036f), glm::vec3(1.0f / 2.2f)), 1.0f};
}

// Whether the Earth or its air may be visible in a tile of a cube face (given by centre, right and down). A face is 2
// wide at distance 1, so the angle from a tile's centre to its corner is at most half of the tile's diagonal.
bool IsNearEarth(const glm::vec3 (&face)[3], int column, int row) {
  const double tile = 2.0 / kTiles;
  const glm::dvec3 centre = glm::dvec3(face[0]) + ((column + 0.5) * tile - 1.0) * glm::dvec3(face[1]) +
                            ((row + 0.5) * tile - 1.0) * glm::dvec3(face[2]);
  const double angle_rad = std::acos(glm::dot(glm::normalize(centre), EarthDirection()));
  return angle_rad < kGlowRadius_rad + 0.5 * tile * std::sqrt(2.0);
}

// SplitMix64 [Steele et al. 2014], scaled to [0, 1).
double NextUnit(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
}

}  // namespace

core::Result<Sky> Sky::Create(const glm::dvec3& sun_direction_W) {
  Sky sky;
  auto background = MakeProgram("sky", kSkyVertex, kSkyFragment);
  if (!background) return tl::unexpected(background.error());
  sky.background_ = std::move(*background);
  auto star = MakeProgram("star", kStarVertex, kStarFragment);
  if (!star) return tl::unexpected(star.error());
  sky.star_ = std::move(*star);
  sky.nothing_ = MakeVertexArray();
  if (auto baked = sky.Bake(sun_direction_W); !baked) return tl::unexpected(baked.error());
  sky.MakeStars();
  glEnable(GL_PROGRAM_POINT_SIZE);
  glEnable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
  return sky;
}

core::Result<void> Sky::Bake(const glm::dvec3& sun_direction_W) {
  const auto earth = MakeProgram("earth", kEarthVertex, kEarthFragment);
  if (!earth) return tl::unexpected(earth.error());
  GLuint cube = 0;
  glCreateTextures(GL_TEXTURE_CUBE_MAP, 1, &cube);
  cube_ = GlTexture(cube);
  glTextureStorage2D(cube, 1, GL_RGBA8, kFace_px, kFace_px);
  glTextureParameteri(cube, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(cube, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  GLuint framebuffer_id = 0;
  glCreateFramebuffers(1, &framebuffer_id);
  const GlFramebuffer framebuffer(framebuffer_id);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glEnable(GL_SCISSOR_TEST);  // spares a software renderer the Earth's shader in tiles without it
  glViewport(0, 0, kFace_px, kFace_px);
  glUseProgram(earth->id());
  glUniform3fv(3, 1, glm::value_ptr(glm::vec3(glm::normalize(sun_direction_W))));
  glBindVertexArray(nothing_.id());
  // Centre, right and down of each face in OpenGL's cube map layout.
  const glm::vec3 faces[6][3] = {{{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
                                 {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
                                 {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}}};
  for (int face = 0; face < 6; ++face) {
    glNamedFramebufferTextureLayer(framebuffer_id, GL_COLOR_ATTACHMENT0, cube, 0, face);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_id);
    for (int k = 0; k < 3; ++k) glUniform3fv(k, 1, glm::value_ptr(faces[face][k]));
    glScissor(0, 0, kFace_px, kFace_px);
    glClearBufferfv(GL_COLOR, 0, glm::value_ptr(EmptySpace()));
    for (int tile = 0; tile < kTiles * kTiles; ++tile) {
      const int column = tile % kTiles, row = tile / kTiles;
      if (!IsNearEarth(faces[face], column, row)) continue;
      glScissor(column * kTile_px, row * kTile_px, kTile_px, kTile_px);
      glDrawArrays(GL_TRIANGLES, 0, 3);
    }
  }
  glDisable(GL_SCISSOR_TEST);
  return {};
}

void Sky::MakeStars() {
  std::vector<glm::vec4> stars;
  std::uint64_t state = 2016;
  for (int i = 0; i < kStars; ++i) {
    const double z = 2.0 * NextUnit(state) - 1.0;
    const double angle = 2.0 * std::acos(-1.0) * NextUnit(state);
    const double ring = std::sqrt(1.0 - z * z);
    const double rank = NextUnit(state);
    const glm::dvec3 direction(ring * std::cos(angle), ring * std::sin(angle), z);
    if (glm::dot(direction, EarthDirection()) > std::cos(kAirRadius_rad)) continue;
    stars.emplace_back(glm::vec3(direction), 0.14 + 0.84 * rank * rank * rank * rank);
  }
  num_stars_ = static_cast<int>(stars.size());
  star_vertices_ = MakeBuffer(stars.data(), stars.size() * sizeof(glm::vec4));
  star_layout_ = MakeVertexArray();
  glVertexArrayVertexBuffer(star_layout_.id(), 0, star_vertices_.id(), 0, sizeof(glm::vec4));
  glEnableVertexArrayAttrib(star_layout_.id(), 0);
  glVertexArrayAttribFormat(star_layout_.id(), 0, 4, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(star_layout_.id(), 0, 0);
}

void Sky::Draw(const glm::mat4& clip_sky, int target_height) const {
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_FALSE);
  glUseProgram(background_.id());
  glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(glm::inverse(clip_sky)));
  glBindTextureUnit(0, cube_.id());
  glBindVertexArray(nothing_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glUseProgram(star_.id());
  glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(clip_sky));
  glUniform1f(1, std::max(1.0f, static_cast<float>(target_height) / 360.0f));
  glBindVertexArray(star_layout_.id());
  glDrawArrays(GL_POINTS, 0, num_stars_);
}

}  // namespace visual_node
