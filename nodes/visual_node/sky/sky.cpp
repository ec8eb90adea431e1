#include "nodes/visual_node/sky/sky.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/gtc/type_ptr.hpp>
#include <span>
#include <vector>

#include "nodes/visual_node/sky/disc_rectangle.hpp"
#include "nodes/visual_node/sky/fine_structure.hpp"
#include "nodes/visual_node/sky/ground.hpp"
#include "nodes/visual_node/sky/sky_shaders.hpp"
#include "space/orbit.hpp"
#include "space/stars/star_file.hpp"
#include "view/appearance/environment_light.hpp"
#include "vps/asset/cooked_object.hpp"

namespace visual_node {
namespace {

// 10 km on the ground, half of what the pictures of it have.
constexpr int kFace_px = 1024;
constexpr int kTile_px = 64;
constexpr int kTiles = kFace_px / kTile_px;

// Centre, right and down of each face in OpenGL's cube map layout.
constexpr glm::vec3 kFaces[6][3] = {{{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
                                    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
                                    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}}};

const glm::vec3 kGlare(0.35f, 0.34f, 0.32f);  // of the sun in the camera, by eye
constexpr float kGlareReach = 0.2f;           // beyond, it is exp(-10) of that: a twentieth of a code

// What is drawn from now on; false: nothing.
bool LimitTo(const glm::ivec4& box) {
  if (box.z <= 0 || box.w <= 0) return false;
  glEnable(GL_SCISSOR_TEST);
  glScissor(box.x, box.y, box.z, box.w);
  return true;
}

glm::dvec3 TileCentre(int face, int column, int row) {
  const double tile = 2.0 / kTiles;
  return glm::normalize(glm::dvec3(kFaces[face][0]) + ((column + 0.5) * tile - 1.0) * glm::dvec3(kFaces[face][1]) +
                        ((row + 0.5) * tile - 1.0) * glm::dvec3(kFaces[face][2]));
}

GlTexture MakeCube(GLenum format) {
  GLuint cube = 0;
  glCreateTextures(GL_TEXTURE_CUBE_MAP, 1, &cube);
  glTextureStorage2D(cube, 1, format, kFace_px, kFace_px);
  glTextureParameteri(cube, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(cube, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return GlTexture(cube);
}

// Columns go round the Earth.
GlTexture MapTexture(GLenum format, const picture::Image& map) {
  GlTexture texture = MakeTexture(format, map.width, map.height);
  glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
  glTextureSubImage2D(texture.id(), 0, 0, 0, map.width, map.height, GL_RGBA, GL_UNSIGNED_BYTE, map.rgba.data());
  return texture;
}

// Where there is water its colours are 0, so that filtering mixes no colour of water into a coast: they are reflectance
// times the share of land.
GlTexture LandTexture(picture::Image colors) {
  for (std::size_t k = 0; k < colors.rgba.size(); k += 4) {
    if (colors.rgba[k + 3] == 0) std::fill_n(&colors.rgba[k], 3, std::uint8_t{0});
  }
  return MapTexture(GL_SRGB8_ALPHA8, colors);
}

// What the maps are too coarse for, as a cube that repeats.
GlTexture FineTexture(const std::vector<std::vector<std::uint8_t>>& levels) {
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_3D, 1, &id);
  GlTexture texture(id);
  glTextureStorage3D(id, static_cast<GLsizei>(levels.size()), GL_RG8, kFineSize, kFineSize, kFineSize);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const GLsizei size = kFineSize >> i;
    glTextureSubImage3D(id, static_cast<GLint>(i), 0, 0, 0, size, size, size, GL_RG, GL_UNSIGNED_BYTE,
                        levels[i].data());
  }
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

std::vector<std::vector<std::uint8_t>> FineLevels() {
  std::vector<std::vector<std::uint8_t>> levels = {FineStructure()};
  for (int size = kFineSize; size > 1; size /= 2) levels.push_back(HalveFine(levels.back(), size));
  return levels;
}

}  // namespace

core::Result<SkyData> SkyData::Make() {
  auto ground = ReadGround();
  if (!ground) return tl::unexpected(ground.error());
  const space::Catalogue catalogue = space::LoadStars(vps::DefaultCacheFolder() / space::kFullCatalogueName);
  return SkyData{std::move(*ground), FineLevels(), space::StarField(catalogue.stars), catalogue.note};
}

core::Result<Sky> Sky::Create(const SkyData& data) {
  Sky sky;
  auto stars = MakeProgram("stars", kSkyVertex, kStarsFragment);
  if (!stars) return tl::unexpected(stars.error());
  sky.star_light_ = std::move(*stars);
  auto sun = MakeProgram("sun", kSkyVertex, kSunFragment);
  if (!sun) return tl::unexpected(sun.error());
  sky.sun_ = std::move(*sun);
  auto moon = MakeProgram("Moon", kSkyVertex, kMoonFragment);
  if (!moon) return tl::unexpected(moon.error());
  sky.moon_ = std::move(*moon);
  auto surface = MakeProgram("ground", kEarthVertex, kEarthFragment);
  if (!surface) return tl::unexpected(surface.error());
  sky.ground_ = std::move(*surface);
  auto earth = MakeProgram("earth and air", kSkyVertex, kEarthAirFragment);
  if (!earth) return tl::unexpected(earth.error());
  sky.earth_ = std::move(*earth);
  sky.SetAir(space::AirFromSpace::Vacuum());
  sky.nothing_ = MakeVertexArray();

  sky.cube_ = MakeCube(GL_RGBA8);
  sky.lights_cube_ = MakeCube(GL_R8);
  glEnable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
  GLuint framebuffer = 0;
  glCreateFramebuffers(1, &framebuffer);
  sky.bake_ = GlFramebuffer(framebuffer);
  constexpr GLenum kOutputs[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glNamedFramebufferDrawBuffers(framebuffer, 2, kOutputs);
  sky.is_baked_.assign(6 * kTiles * kTiles, false);

  sky.land_ = LandTexture(data.ground.colors);
  sky.clouds_ = MapTexture(GL_R8, data.ground.clouds);
  sky.lights_ = MapTexture(GL_R8, data.ground.lights);
  sky.fine_ = FineTexture(data.fine);
  sky.field_ = data.stars;
  sky.note_ = data.note;
  return sky;
}

void Sky::SetAir(const space::AirFromSpace& air) {
  constexpr int kRows = space::AirFromSpace::kThroughRows, kGround = space::AirFromSpace::kGroundSamples;
  air_ = air;
  scattering_ = MakeTexture(GL_RGBA32F, air.num_nu * air.num_mu_s, air.num_mu);
  glTextureSubImage2D(scattering_.id(), 0, 0, 0, air.num_nu * air.num_mu_s, air.num_mu, GL_RGBA, GL_FLOAT,
                      air.scattering.data());
  through_ = MakeTexture(GL_RGBA32F, kRows, 2);
  glTextureSubImage2D(through_.id(), 0, 0, 0, kRows, 2, GL_RGB, GL_FLOAT, air.through.data());
  ground_light_ = MakeTexture(GL_RGBA32F, kGround, 1);
  glTextureSubImage2D(ground_light_.id(), 0, 0, 0, kGround, 1, GL_RGB, GL_FLOAT, air.ground_light.data());
}

void Sky::Prepare(const space::Surroundings& space, const space::StarCamera& camera) {
  BakeVisible(space);
  Splat(camera);
}

// A tile is in view when its angle from the point below the eye is at most that of the horizon.
void Sky::BakeVisible(const space::Surroundings& space) {
  const glm::dvec3 eye_E = space.X_WE.inverse().translation;
  const double horizon_rad = std::acos(std::min(1.0, space::kEarthMeanRadius_m / glm::length(eye_E)));
  const double tile_rad = std::sqrt(2.0) / kTiles;  // at most: a face is 2 wide at distance 1
  const double least = std::cos(std::min(horizon_rad + tile_rad, std::acos(-1.0)));
  const glm::dvec3 below_E = glm::normalize(eye_E);
  bool is_begun = false;
  for (int face = 0; face < 6; ++face) {
    bool is_face_bound = false;
    for (int tile = 0; tile < kTiles * kTiles; ++tile) {
      const int column = tile % kTiles, row = tile / kTiles;
      const auto index = static_cast<std::size_t>(face * kTiles * kTiles + tile);
      if (is_baked_[index] || glm::dot(TileCentre(face, column, row), below_E) < least) continue;
      is_baked_[index] = true;
      if (!is_begun) {
        is_begun = true;
        glDisable(GL_DEPTH_TEST);
        glDisable(GL_BLEND);
        glEnable(GL_SCISSOR_TEST);
        glBindFramebuffer(GL_FRAMEBUFFER, bake_.id());
        glViewport(0, 0, kFace_px, kFace_px);
        glUseProgram(ground_.id());
        glBindTextureUnit(0, land_.id());
        glBindTextureUnit(1, lights_.id());
        glBindTextureUnit(2, clouds_.id());
        glBindVertexArray(nothing_.id());
      }
      if (!is_face_bound) {
        is_face_bound = true;
        glNamedFramebufferTextureLayer(bake_.id(), GL_COLOR_ATTACHMENT0, cube_.id(), 0, face);
        glNamedFramebufferTextureLayer(bake_.id(), GL_COLOR_ATTACHMENT1, lights_cube_.id(), 0, face);
        for (int k = 0; k < 3; ++k) glUniform3fv(k, 1, glm::value_ptr(kFaces[face][k]));
      }
      glScissor(column * kTile_px, row * kTile_px, kTile_px, kTile_px);
      glDrawArrays(GL_TRIANGLES, 0, 3);
    }
  }
  if (is_begun) glDisable(GL_SCISSOR_TEST);
}

void Sky::Splat(const space::StarCamera& camera) {
  if (camera == splatted_) return;
  const bool is_same_size = camera.width == splatted_.width && camera.height == splatted_.height;
  luminance_.assign(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height), glm::vec4(0.0f));
  field_->AddTo(camera, luminance_);
  if (!is_same_size) stars_ = MakeTexture(GL_RGBA32F, camera.width, camera.height);
  glTextureSubImage2D(stars_.id(), 0, 0, 0, camera.width, camera.height, GL_RGBA, GL_FLOAT, luminance_.data());
  splatted_ = camera;
}

void Sky::Draw(const space::Surroundings& space, const glm::mat4& clip_sky) const {
  const glm::vec3 sun(space::SunLight(space, air_));
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_FALSE);
  glBindVertexArray(nothing_.id());
  DrawBackground(space, clip_sky, sun);
  DrawEarth(space, clip_sky, sun);
}

void Sky::DrawBackground(const space::Surroundings& space, const glm::mat4& clip_sky, const glm::vec3& sun) const {
  const glm::mat4 sky_clip = glm::inverse(clip_sky);
  glUseProgram(star_light_.id());
  glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(sky_clip));
  glBindTextureUnit(0, stars_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);

  const glm::vec3 to_sun(space.sun_direction_W);
  if (LimitTo(DiscRectangle(clip_sky, to_sun, kGlareReach, splatted_.width, splatted_.height))) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    glUseProgram(sun_.id());
    glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(sky_clip));
    glUniform3fv(3, 1, glm::value_ptr(to_sun));
    glUniform3fv(9, 1, glm::value_ptr(kGlare * sun));
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_BLEND);
  }

  const double moon_m = std::max(glm::length(space.moon_position_W), 1.0);
  const glm::vec3 to_moon(space.moon_position_W / moon_m);
  const auto moon_sine = static_cast<float>(space::kMoonRadius_m / moon_m);
  if (LimitTo(DiscRectangle(clip_sky, to_moon, moon_sine, splatted_.width, splatted_.height))) {
    glUseProgram(moon_.id());
    glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(sky_clip));
    glUniform3fv(3, 1, glm::value_ptr(to_sun));
    glUniform4f(4, to_moon.x, to_moon.y, to_moon.z, moon_sine);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }
  glDisable(GL_SCISSOR_TEST);
}

void Sky::DrawEarth(const space::Surroundings& space, const glm::mat4& clip_sky, const glm::vec3& sun) const {
  const double distance_m = std::max(glm::length(space.X_WE.translation), 1.0);
  const glm::vec3 to_earth(space.X_WE.translation / distance_m);
  const double bottom_m = air_.mapping.shell().bottom, top = air_.mapping.shell().top / bottom_m;
  const auto top_sine = static_cast<float>(std::min(1.0, top * bottom_m / distance_m));
  const glm::ivec4 box = DiscRectangle(clip_sky, to_earth, top_sine, splatted_.width, splatted_.height);
  if (!LimitTo(box)) return;
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_SRC1_COLOR);
  glUseProgram(earth_.id());
  glUniformMatrix4fv(0, 1, GL_FALSE, glm::value_ptr(glm::inverse(clip_sky)));
  glUniform4f(1, to_earth.x, to_earth.y, to_earth.z, static_cast<float>(bottom_m / distance_m));
  glUniformMatrix3fv(2, 1, GL_FALSE, glm::value_ptr(glm::mat3(glm::mat3_cast(glm::conjugate(space.X_WE.rotation)))));
  glUniform3fv(3, 1, glm::value_ptr(glm::vec3(space.sun_direction_W)));
  const double horizon = std::sqrt((top - 1.0) * (top + 1.0));
  glUniform4f(5, static_cast<float>(top), static_cast<float>(horizon), air_.least_mu_s, air_.mapping.lowest());
  glUniform4f(6, air_.mie_ratio.x, air_.mie_ratio.y, air_.mie_ratio.z, air_.mie_g);
  glUniform3fv(7, 1, glm::value_ptr(view::kSunColor));
  glUniform3f(8, static_cast<float>(air_.num_mu), static_cast<float>(air_.num_nu), static_cast<float>(air_.num_mu_s));
  glUniform3fv(9, 1, glm::value_ptr(kGlare * sun));
  glBindTextureUnit(0, scattering_.id());
  glBindTextureUnit(1, cube_.id());
  glBindTextureUnit(2, through_.id());
  glBindTextureUnit(3, ground_light_.id());
  glBindTextureUnit(4, lights_cube_.id());
  glBindTextureUnit(5, fine_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
}

}  // namespace visual_node
