#include "nodes/visual_node/gl/gl_objects.hpp"

#include <algorithm>
#include <vector>

namespace visual_node {
namespace {

core::Result<GLuint> Compile(const std::string& name, GLenum kind, const char* source) {
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  GLint is_ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &is_ok);
  if (is_ok == GL_TRUE) return shader;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  glDeleteShader(shader);
  return core::Fail(core::ErrorCode::kUnsupported, "the driver cannot compile shader '" + name + "': " + log);
}

}  // namespace

GlBuffer MakeBuffer(const void* data, std::size_t num_bytes) {
  GLuint id = 0;
  glCreateBuffers(1, &id);
  // OpenGL refuses a buffer of size 0; an empty mesh is allowed here.
  glNamedBufferStorage(id, static_cast<GLsizeiptr>(std::max<std::size_t>(num_bytes, 1)), num_bytes > 0 ? data : nullptr,
                       GL_DYNAMIC_STORAGE_BIT);
  return GlBuffer(id);
}

GlVertexArray MakeVertexArray() {
  GLuint id = 0;
  glCreateVertexArrays(1, &id);
  return GlVertexArray(id);
}

GlTexture MakeTexture(GLenum format, int width, int height) {
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &id);
  glTextureStorage2D(id, 1, format, width, height);
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return GlTexture(id);
}

core::Result<GlProgram> MakeProgram(const std::string& name, const char* vertex_source, const char* fragment_source) {
  const core::Result<GLuint> vertex = Compile(name + " (vertex)", GL_VERTEX_SHADER, vertex_source);
  if (!vertex) return tl::unexpected(vertex.error());
  const core::Result<GLuint> fragment = Compile(name + " (fragment)", GL_FRAGMENT_SHADER, fragment_source);
  if (!fragment) {
    glDeleteShader(*vertex);
    return tl::unexpected(fragment.error());
  }
  GlProgram program(glCreateProgram());
  glAttachShader(program.id(), *vertex);
  glAttachShader(program.id(), *fragment);
  glLinkProgram(program.id());
  glDeleteShader(*vertex);
  glDeleteShader(*fragment);
  GLint is_ok = 0;
  glGetProgramiv(program.id(), GL_LINK_STATUS, &is_ok);
  if (is_ok == GL_TRUE) return program;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetProgramInfoLog(program.id(), static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  return core::Fail(core::ErrorCode::kUnsupported, "the driver cannot link shader '" + name + "': " + log);
}

RenderTarget::RenderTarget(int width, int height)
    : width_(width),
      height_(height),
      color_(MakeTexture(GL_RGBA8, width, height)),
      depth_(MakeTexture(GL_DEPTH_COMPONENT24, width, height)) {
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  framebuffer_ = GlFramebuffer(id);
  glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, color_.id(), 0);
  glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, depth_.id(), 0);
}

Image RenderTarget::Read() const {
  Image bottom_up(width_, height_);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.id());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, bottom_up.rgba.data());
  Image image(width_, height_);
  const std::size_t row_bytes = static_cast<std::size_t>(width_) * 4;
  for (int y = 0; y < height_; ++y) {
    const std::uint8_t* row = bottom_up.Pixel(0, height_ - 1 - y);
    std::copy(row, row + row_bytes, image.Pixel(0, y));
  }
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
  return image;
}

}  // namespace visual_node
