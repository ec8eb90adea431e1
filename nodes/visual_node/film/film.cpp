#include "nodes/visual_node/film/film.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "nodes/visual_node/film/film_shaders.hpp"
#include "view/appearance/tone_curve.hpp"

namespace visual_node {
namespace {

constexpr int kMeterWidth = 32, kMeterHeight = 18;  // with 16 samples each: 9216

GlFramebuffer MakeFramebuffer(GLuint color, GLuint depth = 0) {
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, color, 0);
  if (depth != 0) glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, depth, 0);
  return GlFramebuffer(id);
}

}  // namespace

core::Result<Film> Film::Create(bool by_processor) {
  Film film;
  film.by_processor_ = by_processor;
  auto develop =
      MakeProgram("develop", kFilmVertex, (std::string("#version 450 core\n") + kToneCurve + kDevelopFragment).c_str());
  if (!develop) return tl::unexpected(develop.error());
  film.develop_ = std::move(*develop);
  auto smooth = MakeProgram("smooth", kFilmVertex, kSmoothFragment);
  if (!smooth) return tl::unexpected(smooth.error());
  film.smooth_ = std::move(*smooth);
  auto meter = MakeProgram("meter", kFilmVertex, kMeterFragment);
  if (!meter) return tl::unexpected(meter.error());
  film.meter_ = std::move(*meter);
  film.nothing_ = MakeVertexArray();
  film.sums_ = MakeTexture(GL_RG32F, kMeterWidth, kMeterHeight);
  film.sums_framebuffer_ = MakeFramebuffer(film.sums_.id());
  return film;
}

void Film::Resize(int width, int height) {
  width_ = width;
  height_ = height;
  light_ = MakeTexture(GL_RGBA16F, width, height);
  depth_ = MakeTexture(GL_DEPTH_COMPONENT24, width, height);
  developed_ = MakeTexture(GL_RGBA8, width, height);
  smoothed_ = MakeTexture(GL_RGBA8, width, height);
  light_framebuffer_ = MakeFramebuffer(light_.id(), depth_.id());
  developed_framebuffer_ = MakeFramebuffer(developed_.id());
  smoothed_framebuffer_ = MakeFramebuffer(smoothed_.id());
}

void Film::Begin(int width, int height) {
  if (width != width_ || height != height_) Resize(width, height);
  is_read_ = false;
  glBindFramebuffer(GL_FRAMEBUFFER, light_framebuffer_.id());
  glViewport(0, 0, width, height);
  glDepthMask(GL_TRUE);
  const float far = 1.0f;  // light needs no clearing, as the sky fills the rest
  glClearBufferfv(GL_DEPTH, 0, &far);
}

void Film::Develop(float exposure, const RenderTarget& target) {
  if (by_processor_) {
    DevelopByProcessor(exposure, target);
  } else {
    DevelopByShaders(exposure, target);
  }
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
  glViewport(0, 0, target.width(), target.height());
}

void Film::ReadLightBits() {
  if (std::exchange(is_read_, true)) return;
  light_bits_.resize(std::size_t{4} * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  glGetTextureImage(light_.id(), 0, GL_RGBA, GL_HALF_FLOAT,
                    static_cast<GLsizei>(light_bits_.size() * sizeof light_bits_[0]), light_bits_.data());
}

void Film::DevelopByProcessor(float exposure, const RenderTarget& target) {
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  ReadLightBits();
  const auto picture = darkroom_.Develop(light_bits_, {width_, height_}, exposure, {target.width(), target.height()});
  glTextureSubImage2D(target.color(), 0, 0, 0, target.width(), target.height(), GL_RGBA, GL_UNSIGNED_BYTE,
                      picture.data());
}

void Film::DevelopByShaders(float exposure, const RenderTarget& target) {
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glBindVertexArray(nothing_.id());
  glBindFramebuffer(GL_FRAMEBUFFER, developed_framebuffer_.id());
  glViewport(0, 0, width_, height_);
  glUseProgram(develop_.id());
  glUniform1f(0, exposure);
  glBindTextureUnit(0, light_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);

  const bool is_full_size = width_ == target.width() && height_ == target.height();
  glBindFramebuffer(GL_FRAMEBUFFER, is_full_size ? target.framebuffer() : smoothed_framebuffer_.id());
  glUseProgram(smooth_.id());
  glUniform2f(0, 1.0f / static_cast<float>(width_), 1.0f / static_cast<float>(height_));
  glBindTextureUnit(0, developed_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  if (!is_full_size) {
    glBlitNamedFramebuffer(smoothed_framebuffer_.id(), target.framebuffer(), 0, 0, width_, height_, 0, 0,
                           target.width(), target.height(), GL_COLOR_BUFFER_BIT, GL_LINEAR);
  }
}

std::optional<float> Film::MeanLuminance() {
  if (by_processor_) {
    ReadLightBits();
    return MeanLuminanceOf(light_bits_, {width_, height_}, {kMeterWidth, kMeterHeight});
  }
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glBindVertexArray(nothing_.id());
  glBindFramebuffer(GL_FRAMEBUFFER, sums_framebuffer_.id());
  glViewport(0, 0, kMeterWidth, kMeterHeight);
  glUseProgram(meter_.id());
  glUniform2f(0, static_cast<float>(width_) / kMeterWidth, static_cast<float>(height_) / kMeterHeight);
  glBindTextureUnit(0, light_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  std::vector<float> sums(std::size_t{2} * kMeterWidth * kMeterHeight);
  glReadPixels(0, 0, kMeterWidth, kMeterHeight, GL_RG, GL_FLOAT, sums.data());
  float sum = 0.0f, number = 0.0f;
  for (std::size_t i = 0; i < sums.size(); i += 2) {
    sum += sums[i];
    number += sums[i + 1];
  }
  if (number == 0.0f) return std::nullopt;
  return std::exp2(sum / number);
}

std::vector<float> Film::ReadLight() const {
  std::vector<float> light(std::size_t{4} * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  glGetTextureImage(light_.id(), 0, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(light.size() * sizeof(float)),
                    light.data());
  return light;
}

}  // namespace visual_node
