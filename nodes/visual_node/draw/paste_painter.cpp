#include "nodes/visual_node/draw/paste_painter.hpp"

#include <cmath>

#include "nodes/visual_node/film/film_shaders.hpp"

namespace visual_node {
namespace {

// --- Rows of the canvas are from the top. Its depths are codes (tiles::PackDepth); the film's are OpenGL's:
// z_ndc = (f + n) / (f - n) - 2 f n / ((f - n) d).
constexpr const char* kPasteFragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D u_light;
layout(binding = 1) uniform usampler2D u_depth;
layout(location = 0) uniform int u_height;
layout(location = 1) uniform vec2 u_depth_code;  // nearest depth [m], logarithm for each step of the code
layout(location = 2) uniform vec2 u_clip;        // of the film's depth: a - b / d
out vec4 o_light;
void main() {
  ivec2 at = ivec2(int(gl_FragCoord.x), u_height - 1 - int(gl_FragCoord.y));
  uint code = texelFetch(u_depth, at, 0).r;
  if (code == 0u) discard;
  float d = u_depth_code.x * exp(u_depth_code.y * float(code - 1u));
  gl_FragDepth = clamp(u_clip.x - u_clip.y / d, 0.0, 1.0);
  o_light = vec4(texelFetch(u_light, at, 0).rgb, 1.0);
}
)";

}  // namespace

core::Result<PastePainter> PastePainter::Create() {
  PastePainter painter;
  auto program = MakeProgram("paste", kFilmVertex, kPasteFragment);
  if (!program) return tl::unexpected(program.error());
  painter.program_ = std::move(*program);
  painter.nothing_ = MakeVertexArray();
  return painter;
}

void PastePainter::Draw(const Pasted& surfaces, float near_m, float far_m) {
  const tiles::Canvas& canvas = *surfaces.canvas;
  const tiles::Tile& at = surfaces.at;
  if (at.width != width_ || at.height != height_) {
    width_ = at.width;
    height_ = at.height;
    light_ = MakeTexture(GL_RGB9_E5, width_, height_);
    depth_ = MakeTexture(GL_R16UI, width_, height_);
    glTextureParameteri(depth_.id(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);  // whole numbers are not mixed
    glTextureParameteri(depth_.id(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, canvas.width);
  glPixelStorei(GL_UNPACK_SKIP_PIXELS, at.x);
  glPixelStorei(GL_UNPACK_SKIP_ROWS, at.y);
  glTextureSubImage2D(light_.id(), 0, 0, 0, width_, height_, GL_RGB, GL_UNSIGNED_INT_5_9_9_9_REV, canvas.light.data());
  glTextureSubImage2D(depth_.id(), 0, 0, 0, width_, height_, GL_RED_INTEGER, GL_UNSIGNED_SHORT, canvas.depth.data());
  glPixelStorei(GL_UNPACK_SKIP_ROWS, 0);
  glPixelStorei(GL_UNPACK_SKIP_PIXELS, 0);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_ALWAYS);
  glUseProgram(program_.id());
  glBindVertexArray(nothing_.id());
  glUniform1i(0, height_);
  glUniform2f(1, tiles::kNearest_m, std::log(tiles::kFarthest_m / tiles::kNearest_m) / 65534.0f);
  glUniform2f(2, far_m / (far_m - near_m), far_m * near_m / (far_m - near_m));
  glBindTextureUnit(0, light_.id());
  glBindTextureUnit(1, depth_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDepthFunc(GL_LEQUAL);
}

}  // namespace visual_node
