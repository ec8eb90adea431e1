#pragma once

#include <epoxy/gl.h>

#include <string>
#include <utility>

#include "core/result.hpp"
#include "picture/image.hpp"

namespace visual_node {

using picture::Image;

// Owns one OpenGL name; Delete calls the matching glDelete function.
template <typename Delete>
class GlName {
 public:
  GlName() = default;
  explicit GlName(GLuint id) : id_(id) {}
  GlName(GlName&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~GlName() {
    if (id_ != 0) Delete{}(id_);
  }
  [[nodiscard]] GLuint id() const { return id_; }

 private:
  GLuint id_ = 0;
};

struct DeleteBuffer {
  void operator()(GLuint id) const { glDeleteBuffers(1, &id); }
};
struct DeleteVertexArray {
  void operator()(GLuint id) const { glDeleteVertexArrays(1, &id); }
};
struct DeleteTexture {
  void operator()(GLuint id) const { glDeleteTextures(1, &id); }
};
struct DeleteSampler {
  void operator()(GLuint id) const { glDeleteSamplers(1, &id); }
};
struct DeleteFramebuffer {
  void operator()(GLuint id) const { glDeleteFramebuffers(1, &id); }
};
struct DeleteProgram {
  void operator()(GLuint id) const { glDeleteProgram(id); }
};

using GlBuffer = GlName<DeleteBuffer>;
using GlVertexArray = GlName<DeleteVertexArray>;
using GlTexture = GlName<DeleteTexture>;
using GlSampler = GlName<DeleteSampler>;
using GlFramebuffer = GlName<DeleteFramebuffer>;
using GlProgram = GlName<DeleteProgram>;

GlBuffer MakeBuffer(const void* data, std::size_t num_bytes);
GlVertexArray MakeVertexArray();
GlTexture MakeTexture(GLenum format, int width, int height);

// Compiles and links. Error: kUnsupported, with the driver's log.
core::Result<GlProgram> MakeProgram(const std::string& name, const char* vertex_source, const char* fragment_source);

// Off-screen framebuffer of any size.
class RenderTarget {
 public:
  RenderTarget(int width, int height);
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] GLuint framebuffer() const { return framebuffer_.id(); }
  [[nodiscard]] GLuint color() const { return color_.id(); }
  [[nodiscard]] Image Read() const;  // waits until the frame is finished

 private:
  int width_;
  int height_;
  GlTexture color_;
  GlTexture depth_;
  GlFramebuffer framebuffer_;
};

}  // namespace visual_node
