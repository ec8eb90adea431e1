#include "nodes/visual_node/draw/object_pass.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/gtc/type_ptr.hpp>
#include <nlohmann/json.hpp>

#include "nodes/visual_node/gl/matrix.hpp"

namespace visual_node {
namespace {

constexpr const char* kVertex = R"(#version 450 core
layout(location = 0) in vec3 p_M;
layout(location = 0) uniform mat4 X_EM;    // to the eye, which looks along -z
layout(location = 1) uniform mat4 clip_E;
out float depth_m;
void main() {
  vec4 p_E = X_EM * vec4(p_M, 1.0);
  depth_m = -p_E.z;
  gl_Position = clip_E * p_E;
}
)";

constexpr const char* kFragment = R"(#version 450 core
in float depth_m;
layout(location = 2) uniform uint id;
layout(location = 0) out uint seen;
layout(location = 1) out float depth;
void main() {
  seen = id;
  depth = depth_m;
}
)";

void SetMatrix(GLint location, const glm::dmat4& matrix) {
  const glm::mat4 single(matrix);
  glUniformMatrix4fv(location, 1, GL_FALSE, glm::value_ptr(single));
}

// OpenGL's rows come from the bottom.
template <class T>
picture::Measured<T> FromTop(const picture::Measured<T>& bottom_up) {
  picture::Measured<T> image(bottom_up.width, bottom_up.height);
  const auto width = static_cast<std::size_t>(image.width);
  for (int y = 0; y < image.height; ++y) {
    const T* row = bottom_up.Pixel(0, image.height - 1 - y);
    std::copy(row, row + width, image.values.begin() + static_cast<std::ptrdiff_t>(width) * y);
  }
  return image;
}

template <class T>
picture::Measured<T> Read(GLuint framebuffer, GLenum attachment, GLenum format, GLenum type, int width, int height) {
  picture::Measured<T> pixels(width, height);
  glNamedFramebufferReadBuffer(framebuffer, attachment);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, format, type, pixels.values.data());
  return FromTop(pixels);
}

}  // namespace

core::Result<ObjectPass> ObjectPass::Create() {
  auto program = MakeProgram("objects", kVertex, kFragment);
  if (!program) return tl::unexpected(program.error());
  ObjectPass pass;
  pass.program_ = std::move(*program);
  return pass;
}

ObjectPicture ObjectPass::Draw(const Renderer& renderer, const view::Scene& scene, const scene::Camera& given,
                               int width, int height) const {
  const double aspect = static_cast<double>(width) / height;
  return Draw(renderer, scene, view::FrustumOf(view::PlaceCamera(given, scene), aspect), width, height);
}

ObjectPicture ObjectPass::Draw(const Renderer& renderer, const view::Scene& scene, const view::Frustum& eye, int width,
                               int height) const {
  const GlTexture ids = MakeTexture(GL_R32UI, width, height);
  const GlTexture depths = MakeTexture(GL_R32F, width, height);
  const GlTexture nearest = MakeTexture(GL_DEPTH_COMPONENT32F, width, height);
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  const GlFramebuffer framebuffer(name);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, ids.id(), 0);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT1, depths.id(), 0);
  glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, nearest.id(), 0);
  const GLenum both[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glNamedFramebufferDrawBuffers(name, 2, both);
  glBindFramebuffer(GL_FRAMEBUFFER, name);
  glViewport(0, 0, width, height);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_TRUE);
  const GLuint nothing[4] = {};
  const float no_depth[4] = {}, far = 1.0f;
  glClearBufferuiv(GL_COLOR, 0, nothing);
  glClearBufferfv(GL_COLOR, 1, no_depth);
  glClearBufferfv(GL_DEPTH, 0, &far);

  const glm::dmat4 view_W = view::ViewMatrix(eye);
  glUseProgram(program_.id());
  SetMatrix(1, view::ProjectionMatrix(eye, Renderer::kNear_m, Renderer::kFar_m));
  const auto draw = [&](const GpuMesh& mesh, const glm::dmat4& X_WM, std::size_t instance) {
    SetMatrix(0, view_W * X_WM);
    glUniform1ui(2, static_cast<GLuint>(instance + 1));
    glBindVertexArray(mesh.layout.id());
    glDrawElements(GL_TRIANGLES, mesh.num_indices, GL_UNSIGNED_INT, nullptr);
  };
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const view::Instance& instance = scene.instances[i];
    if (instance.is_visible) draw(renderer.meshes()[instance.mesh], glm::dmat4(ToMatrix(instance.X_WM)), i);
  }
  for (std::size_t i = 0; i < scene.sheets.size(); ++i) {
    if (scene.sheets[i].is_visible) draw(renderer.sheets()[i], glm::dmat4(1.0), scene.sheets[i].instance);
  }

  const auto wide = Read<std::uint32_t>(name, GL_COLOR_ATTACHMENT0, GL_RED_INTEGER, GL_UNSIGNED_INT, width, height);
  ObjectPicture picture{{width, height}, Read<float>(name, GL_COLOR_ATTACHMENT1, GL_RED, GL_FLOAT, width, height)};
  std::transform(wide.values.begin(), wide.values.end(), picture.ids.values.begin(),
                 [](std::uint32_t id) { return static_cast<std::uint16_t>(id); });
  return picture;
}

picture::Measured<std::uint16_t> ToMillimetres(const picture::Measured<float>& depth_m) {
  picture::Measured<std::uint16_t> millimetres(depth_m.width, depth_m.height);
  std::transform(depth_m.values.begin(), depth_m.values.end(), millimetres.values.begin(), [](float depth) {
    return static_cast<std::uint16_t>(std::clamp(std::round(1e3f * depth), 0.0f, 65535.0f));
  });
  return millimetres;
}

core::Result<void> WriteIdNames(const view::Assets& assets, const std::filesystem::path& file) {
  nlohmann::ordered_json names = {{"0", nullptr}};
  for (std::size_t i = 0; i < assets.instance_names.size(); ++i) {
    names[std::to_string(i + 1)] = assets.instance_names[i];
  }
  std::ofstream out(file);
  out << names.dump(2) << "\n";
  if (out.flush()) return {};
  return core::Fail(core::ErrorCode::kIo, "cannot write " + file.string() + "; is the folder writable?");
}

}  // namespace visual_node
