#include "nodes/visual_node/draw/composer.hpp"

#include <cmath>

#include "nodes/visual_node/film/film_shaders.hpp"

namespace visual_node {
namespace {

constexpr std::size_t kMostSizes = 16;  // of views, more than a layout has

constexpr const char* kDecodeSrgb = R"(
vec3 DecodeSrgb(vec3 encoded) {
  return mix(encoded / 12.92, pow((encoded + 0.055) / 1.055, vec3(2.4)), greaterThan(encoded, vec3(0.04045)));
}
)";

// --- Both eyes' pictures through the matrices of view/stereo.hpp, in linear light.
constexpr const char* kAnaglyphFragment = R"(
layout(binding = 0) uniform sampler2D u_left;
layout(binding = 1) uniform sampler2D u_right;
layout(location = 0) uniform vec2 u_size_px;
layout(location = 1) uniform mat3 u_of_left;
layout(location = 2) uniform mat3 u_of_right;
out vec4 o_color;
void main() {
  vec2 uv = gl_FragCoord.xy / u_size_px;
  vec3 light = u_of_left * DecodeSrgb(texture(u_left, uv).rgb) + u_of_right * DecodeSrgb(texture(u_right, uv).rgb);
  o_color = vec4(EncodeSrgb(clamp(light, 0.0, 1.0)), 1.0);
}
)";

// --- Rows in turn, from the top: the left eye's, the right eye's.
constexpr const char* kInterlacedFragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D u_left;
layout(binding = 1) uniform sampler2D u_right;
layout(location = 0) uniform vec2 u_size_px;
out vec4 o_color;
void main() {
  int row = int(u_size_px.y - gl_FragCoord.y);
  float rows = float((int(u_size_px.y) + 1) / 2);
  vec2 uv = vec2(gl_FragCoord.x / u_size_px.x, 1.0 - (float(row / 2) + 0.5) / rows);
  o_color = vec4((row % 2 == 0 ? texture(u_left, uv) : texture(u_right, uv)).rgb, 1.0);
}
)";

// OpenGL's matrices are columns, those of view/stereo.hpp rows.
void SetRows(GLint location, const std::array<std::array<float, 3>, 3>& rows) {
  glUniformMatrix3fv(location, 1, GL_TRUE, rows[0].data());
}

// A rectangle of a window, in an eye's picture of it: x, y from the bottom, width, height.
glm::ivec4 InEye(const view::Pane& pane, view::Stereo stereo, int samples, int eye_height) {
  const glm::ivec2 size_px = samples * view::EyeSize(stereo, pane.size_px.x, pane.size_px.y);
  const glm::ivec2 corner_px = samples * view::EyeSize(stereo, pane.corner_px.x, pane.corner_px.y);
  return {corner_px.x, eye_height - corner_px.y - size_px.y, size_px};
}

scene::Camera CameraOf(const Composer::Shown& shown, std::size_t pane, const std::string& name) {
  const scene::Camera& camera =
      pane == 0 ? shown.steered : view::CameraFor(*shown.scene.assets, name, shown.scene.step);
  return view::PlaceCamera(camera, shown.scene);
}

}  // namespace

core::Result<Composer> Composer::Create() {
  Composer composer;
  const std::string anaglyph = std::string("#version 450 core\n") + kToneCurve + kDecodeSrgb + kAnaglyphFragment;
  auto made = MakeProgram("anaglyph", kFilmVertex, anaglyph.c_str());
  if (!made) return tl::unexpected(made.error());
  composer.anaglyph_ = std::move(*made);
  made = MakeProgram("interlaced", kFilmVertex, kInterlacedFragment);
  if (!made) return tl::unexpected(made.error());
  composer.interlaced_ = std::move(*made);
  composer.nothing_ = MakeVertexArray();
  return composer;
}

const RenderTarget& Composer::Target(std::size_t eye, const glm::ivec2& size_px) {
  eyes_.resize(std::max(eyes_.size(), eye + 1));
  std::unique_ptr<RenderTarget>& target = eyes_[eye];
  if (target == nullptr || target->width() != size_px.x || target->height() != size_px.y) {
    target = std::make_unique<RenderTarget>(size_px.x, size_px.y);
  }
  return *target;
}

std::vector<SeenView> Composer::Views(const Shown& shown, int width, int height, int samples) {
  const view::Viewing& viewing = shown.composition.viewing;
  const std::size_t num_eyes = viewing.stereo == view::Stereo::kNone ? 1 : 2;
  const std::vector<view::Pane> panes = view::PanesOf(shown.composition.layout, width, height);
  std::vector<SeenView> views;
  for (std::size_t eye = 0; eye < num_eyes; ++eye) {
    for (std::size_t i = 0; i < panes.size(); ++i) {
      const glm::ivec2& size_px = panes[i].size_px;
      const scene::Camera camera = CameraOf(shown, i, panes[i].camera);
      views.push_back({view::FrustaOf(viewing, camera, size_px.x, size_px.y).at(eye),
                       samples * view::EyeSize(viewing.stereo, size_px.x, size_px.y)});
    }
  }
  return views;
}

core::Result<void> Composer::DrawEyes(Renderer& renderer, const Shown& shown, const Look& look,
                                      const RenderTarget& target, int samples) {
  const view::Stereo stereo = shown.composition.viewing.stereo;
  const int width = target.width(), height = target.height();
  drawn_.clear();
  if (shown.composition.is_plain() && samples == 1) {
    drawn_.push_back(&target);
    const scene::Camera camera = view::PlaceCamera(shown.steered, shown.scene);
    return renderer.Draw(shown.scene, view::FrustaOf(shown.composition.viewing, camera, width, height).front(), target,
                         look);
  }
  const std::size_t num_eyes = stereo == view::Stereo::kNone ? 1 : 2;
  const std::vector<view::Pane> panes = view::PanesOf(shown.composition.layout, width, height);
  const bool is_direct = num_eyes == 1 && samples == 1;
  taken_.clear();
  if (look.with_texts) {
    auto taken = renderer.TextBlocks(shown.scene.texts, samples * width, samples * height);
    if (!taken) return tl::unexpected(taken.error());
    taken_ = std::move(*taken);
  }
  for (std::size_t eye = 0; eye < num_eyes; ++eye) {
    const RenderTarget& picture = is_direct ? target : Target(eye, samples * view::EyeSize(stereo, width, height));
    drawn_.push_back(&picture);
    const float black[4] = {0.0f, 0.0f, 0.0f, 1.0f};
    glClearNamedFramebufferfv(picture.framebuffer(), GL_COLOR, 0, black);
    // The steered view last: the light meter looks at what was drawn last.
    for (std::size_t i = panes.size(); i-- > 0;) {
      if (auto drawn = DrawView(renderer, shown, i, panes[i], look, eye, samples, picture); !drawn) return drawn;
    }
    if (!look.with_texts) continue;
    glBindFramebuffer(GL_FRAMEBUFFER, picture.framebuffer());
    glViewport(0, 0, picture.width(), picture.height());
    const Hud hud{shown.scene.texts, {}, shown.scene.graphs};
    if (auto drawn = renderer.DrawTexts(hud, samples * width, samples * height); !drawn) return drawn;
  }
  return {};
}

core::Result<void> Composer::DrawView(Renderer& renderer, const Shown& shown, std::size_t index, const view::Pane& pane,
                                      const Look& look, std::size_t eye, int samples, const RenderTarget& target) {
  const view::Stereo stereo = shown.composition.viewing.stereo;
  const scene::Camera camera = CameraOf(shown, index, pane.camera);
  const view::Frustum frustum =
      view::FrustaOf(shown.composition.viewing, camera, pane.size_px.x, pane.size_px.y).at(eye);
  const glm::ivec4 at = InEye(pane, stereo, samples, target.height());
  Look bare = look;
  bare.with_texts = false;
  if (!look.surfaces.empty()) {
    bare.surfaces = look.surfaces.subspan(eye * shown.composition.layout.num_views() + index, 1);
  }
  const bool is_whole = at.z == target.width() && at.w == target.height();
  if (views_.size() > kMostSizes) views_.clear();  // the window has been dragged larger
  const RenderTarget& picture = is_whole ? target : views_.try_emplace({at.z, at.w}, at.z, at.w).first->second;
  if (auto drawn = renderer.Draw(shown.scene, frustum, picture, bare); !drawn) return drawn;
  if (!is_whole) {
    glBlitNamedFramebuffer(picture.framebuffer(), target.framebuffer(), 0, 0, at.z, at.w, at.x, at.y, at.x + at.z,
                           at.y + at.w, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
  if (!look.with_texts) return {};
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
  glViewport(at.x, at.y, at.z, at.w);
  const glm::ivec2 size_px = samples * pane.size_px;
  std::vector<view::TextLine> name;
  if (shown.composition.layout.is_divided() && index > 0) {
    name.push_back({view::Anchor::kBottomRight, view::TextStyle::kBadge, glm::vec3(1.0f), camera.name});
  }
  static const std::vector<view::Graph> kNoGraphs;
  const Hud seen = HudOf(shown.scene, frustum, size_px.x, size_px.y);
  std::vector<Box> taken = taken_;
  const glm::dvec2 corner_px(samples * pane.corner_px);
  for (Box& box : taken) box = {box.low - corner_px, box.high - corner_px};
  return renderer.DrawTexts({name, seen.labels, kNoGraphs, seen.strokes, taken}, size_px.x, size_px.y);
}

void Composer::Join(view::Stereo stereo, const RenderTarget& target) const {
  if (drawn_.front() == &target) return;
  const int width = target.width(), height = target.height();
  const auto blit = [&](const RenderTarget& eye, int x, int y, int wide, int high) {
    glBlitNamedFramebuffer(eye.framebuffer(), target.framebuffer(), 0, 0, eye.width(), eye.height(), x, y, x + wide,
                           y + high, GL_COLOR_BUFFER_BIT, GL_LINEAR);
  };
  const glm::ivec2 half = view::EyeSize(stereo, width, height);
  switch (stereo) {
    case view::Stereo::kNone:
      blit(*drawn_[0], 0, 0, width, height);
      return;
    case view::Stereo::kSideBySide:
      blit(*drawn_[0], 0, 0, half.x, height);
      blit(*drawn_[1], width - half.x, 0, half.x, height);
      return;
    case view::Stereo::kTopBottom:
      blit(*drawn_[1], 0, 0, width, half.y);
      blit(*drawn_[0], 0, height - half.y, width, half.y);
      return;
    case view::Stereo::kAnaglyph:
    case view::Stereo::kInterlaced:
      break;
  }
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
  glViewport(0, 0, width, height);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glBindVertexArray(nothing_.id());
  glUseProgram(stereo == view::Stereo::kAnaglyph ? anaglyph_.id() : interlaced_.id());
  glUniform2f(0, static_cast<float>(width), static_cast<float>(height));
  if (stereo == view::Stereo::kAnaglyph) {
    SetRows(1, view::kDuboisLeft);
    SetRows(2, view::kDuboisRight);
  }
  glBindTextureUnit(0, drawn_[0]->color());
  glBindTextureUnit(1, drawn_[1]->color());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

std::optional<Spot> Composer::Find(const Shown& shown, int width, int height, const glm::dvec2& at_px) {
  view::Viewing viewing = shown.composition.viewing;
  glm::dvec2 at = at_px;
  std::size_t eye = 0;
  const glm::dvec2 half(0.5 * width, 0.5 * height);
  if (viewing.stereo == view::Stereo::kSideBySide) {
    eye = at.x < half.x ? 0 : 1;
    at.x = 2.0 * std::fmod(at.x, half.x);
  } else if (viewing.stereo == view::Stereo::kTopBottom) {
    eye = at.y < half.y ? 0 : 1;
    at.y = 2.0 * std::fmod(at.y, half.y);
  } else if (viewing.stereo == view::Stereo::kInterlaced) {
    viewing.stereo = view::Stereo::kAnaglyph;  // whole pictures
  }
  const std::vector<view::Pane> panes = view::PanesOf(shown.composition.layout, width, height);
  for (std::size_t i = 0; i < panes.size(); ++i) {
    const glm::dvec2 in_pane = at - glm::dvec2(panes[i].corner_px), size(panes[i].size_px);
    if (in_pane.x < 0.0 || in_pane.y < 0.0 || in_pane.x >= size.x || in_pane.y >= size.y) continue;
    const scene::Camera camera = CameraOf(shown, i, panes[i].camera);
    return Spot{view::FrustaOf(viewing, camera, panes[i].size_px.x, panes[i].size_px.y).at(eye), panes[i].size_px,
                in_pane};
  }
  return std::nullopt;
}

core::Result<Image> RenderSmooth(Renderer& renderer, Composer& composer, const Composer::Shown& shown, int width,
                                 int height, const Pasting& pasting) {
  const RenderTarget target(width, height);
  if (auto drawn = composer.DrawEyes(renderer, shown, {.surfaces = pasting.surfaces}, target, kSmoothSamples); !drawn) {
    return tl::unexpected(drawn.error());
  }
  composer.Join(shown.composition.viewing.stereo, target);
  if (pasting.add) {
    if (auto added = pasting.add(target); !added) return tl::unexpected(added.error());
  }
  return target.Read();
}

}  // namespace visual_node
