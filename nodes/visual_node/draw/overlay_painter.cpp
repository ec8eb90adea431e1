#include "nodes/visual_node/draw/overlay_painter.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <utility>

#include "nodes/visual_node/draw/overlay_shaders.hpp"
#include "nodes/visual_node/film/film_shaders.hpp"
#include "nodes/visual_node/gl/matrix.hpp"

namespace visual_node {
namespace {

constexpr float kHidden = 0.30f;  // opacity of what a part hides; by eye

void SetUniform(GLint location, const glm::mat4& matrix) {
  glUniformMatrix4fv(location, 1, GL_FALSE, glm::value_ptr(matrix));
}

// Axes with the given z.
glm::mat3 FrameOf(const glm::vec3& z) {
  const glm::vec3 x = glm::normalize(glm::cross(std::abs(z.x) < 0.8f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0), z));
  return {x, glm::cross(z, x), z};
}

// Of overlay_shaders.hpp's kRingVertex.
vps::VisualMesh MakeTube() {
  constexpr std::uint32_t kSteps = 40, kSides = 8;
  vps::VisualPrimitive tube;
  for (std::uint32_t i = 0; i <= kSteps; ++i) {
    for (std::uint32_t j = 0; j < kSides; ++j) {
      const float around = 6.2831853f * static_cast<float>(j) / kSides;
      tube.positions.emplace_back(static_cast<float>(i) / kSteps, std::cos(around), std::sin(around));
      if (i == kSteps) continue;
      const std::uint32_t a = i * kSides + j, b = i * kSides + (j + 1) % kSides;
      for (const std::uint32_t k : {a, b, b + kSides, a, b + kSides, a + kSides}) tube.indices.push_back(k);
    }
  }
  tube.normals.resize(tube.positions.size());
  return {{tube}};
}

void DrawMesh(const GpuMesh& mesh) {
  glBindVertexArray(mesh.layout.id());
  glDrawElements(GL_TRIANGLES, mesh.num_indices, GL_UNSIGNED_INT, nullptr);
}

// A shaft or a head from p_W along R_WA's z.
void DrawBody(const GpuMesh& mesh, const glm::vec3& p_W, const glm::mat3& R_WA, float radius_m, float length_m) {
  SetUniform(0, glm::mat4(glm::vec4(radius_m * R_WA[0], 0.0f), glm::vec4(radius_m * R_WA[1], 0.0f),
                          glm::vec4(length_m * R_WA[2], 0.0f), glm::vec4(p_W, 1.0f)));
  DrawMesh(mesh);
}

void SetColor(const glm::vec3& color, float opacity) {
  glUniform4f(2, color.r, color.g, color.b, opacity);
}

// A scene's phantoms, and instances that are transparent or highlighted.
std::vector<view::Phantom> AllPhantoms(const view::Scene& scene, const std::vector<GpuMesh>& meshes) {
  std::vector<view::Phantom> all = scene.phantoms;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const view::Instance& instance = scene.instances[i];
    if (!instance.is_visible) continue;
    const auto index = static_cast<std::uint32_t>(i);
    const std::vector<GpuMesh::Part>& parts = meshes[instance.mesh].parts;
    if (instance.opacity < 1.0f && !parts.empty()) {
      const view::Material& material = instance.is_material_given ? instance.material : parts.front().material;
      all.push_back({index, instance.X_WM, material.base_color, instance.opacity});
    }
    if (instance.highlight > 0.0f) all.push_back({index, instance.X_WM, view::kHighlight, instance.highlight});
  }
  return all;
}

}  // namespace

core::Result<OverlayPainter> OverlayPainter::Create() {
  OverlayPainter painter;
  struct Source {
    GlProgram* program;
    const char* name;
    const char* vertex;
    const char* fragment;
  };
  for (const Source& source : {Source{&painter.body_, "overlay", kOverlayVertex, kOverlayFragment},
                               Source{&painter.ring_, "ring", kRingVertex, kOverlayFragment},
                               Source{&painter.line_, "line", kLineVertex, kFlatFragment},
                               Source{&painter.point_, "point", kPointVertex, kPointFragment},
                               Source{&painter.cube_, "cube", kGrainVertex, kCubeFragment},
                               Source{&painter.sphere_, "sphere", kGrainVertex, kSphereFragment},
                               Source{&painter.phantom_, "phantom", kOverlayVertex, kPhantomFragment},
                               Source{&painter.mix_, "mix", kFilmVertex, kMixFragment}}) {
    auto program = MakeProgram(source.name, source.vertex, source.fragment);
    if (!program) return tl::unexpected(program.error());
    *source.program = std::move(*program);
  }
  painter.shaft_ = Upload(MakeCylinder(10));
  painter.head_ = Upload(MakeCone(14));
  painter.tube_ = Upload(MakeTube());
  painter.nothing_ = MakeVertexArray();
  painter.strip_layout_ = MakeVertexArray();
  painter.set_layout_ = MakeVertexArray();
  for (const GLuint layout : {painter.strip_layout_.id(), painter.set_layout_.id()}) {
    for (const GLuint attribute : {0u, 1u}) {
      glEnableVertexArrayAttrib(layout, attribute);
      glVertexArrayAttribFormat(layout, attribute, 3, GL_FLOAT, GL_FALSE, 0);
      glVertexArrayAttribBinding(layout, attribute, attribute);
    }
  }
  painter.grain_layout_ = MakeVertexArray();
  glEnableVertexArrayAttrib(painter.grain_layout_.id(), 0);
  glVertexArrayAttribBinding(painter.grain_layout_.id(), 0, 0);
  glVertexArrayBindingDivisor(painter.grain_layout_.id(), 0, 1);
  for (const GLuint binding : {0u, 1u}) glVertexArrayBindingDivisor(painter.strip_layout_.id(), binding, 1);
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  painter.framebuffer_ = GlFramebuffer(id);
  return painter;
}

void OverlayPainter::Draw(const view::Scene& scene, const std::vector<GpuMesh>& meshes, const View& view,
                          const Film& film) {
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  for (const view::Cubes& cubes : scene.cubes) DrawCubes(cubes, view);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  DrawPhantoms(scene, meshes, view, film);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  for (const view::Spheres& spheres : scene.spheres) DrawSpheres(spheres, view);
  // Twice: faint without depth test, so that they show through parts, then solid with depth test.
  for (const bool is_solid : {false, true}) {
    is_solid ? glEnable(GL_DEPTH_TEST) : glDisable(GL_DEPTH_TEST);
    const float opacity = is_solid ? 1.0f : kHidden;
    for (const view::LineStrip& line : scene.lines) DrawLine(line, view, film, opacity);
    for (const view::PointSet& set : scene.points) {
      if (is_solid || set.shows_through) DrawPoints(set, view, film, opacity);
    }
    DrawBodies(scene, view, is_solid);
  }
  glDisable(GL_BLEND);
}

void OverlayPainter::UseBodies(const GlProgram& program, const View& view) const {
  glUseProgram(program.id());
  SetUniform(1, view.clip_W);
  glUniform3fv(3, 1, glm::value_ptr(view.eye_W));
  glUniform1f(4, view.exposure);
}

// The solid pass writes depth, so that bodies hide each other.
void OverlayPainter::DrawBodies(const view::Scene& scene, const View& view, bool is_solid) const {
  if (scene.arrows.empty() && scene.axes.empty() && scene.rings.empty()) return;
  const float opacity = is_solid ? 1.0f : kHidden;
  glDepthMask(is_solid ? GL_TRUE : GL_FALSE);
  UseBodies(ring_, view);
  for (const view::RingArrow& ring : scene.rings) DrawRing(ring, view, opacity);
  UseBodies(body_, view);
  for (const view::RingArrow& ring : scene.rings) {  // their heads
    const glm::mat3 R_WR = FrameOf(glm::vec3(ring.axis_W));
    const auto sweep = static_cast<float>(ring.sweep_rad), radius_m = static_cast<float>(ring.radius_m);
    const glm::vec3 outwards = std::cos(sweep) * R_WR[0] + std::sin(sweep) * R_WR[1];
    const glm::vec3 onwards = glm::cross(R_WR[2], outwards);
    SetColor(ring.color, opacity);
    DrawBody(head_, glm::vec3(ring.p_WCentre) + radius_m * outwards, FrameOf(onwards), 0.11f * radius_m,
             0.34f * radius_m);
  }
  for (const view::Arrow& arrow : scene.arrows) DrawArrow(arrow, view, opacity);
  for (const view::Axes& axes : scene.axes) {
    for (int k = 0; k < 3; ++k) {
      glm::dvec3 along(0.0), color(0.1);
      along[k] = axes.length_m;
      color[k] = 1.0;
      DrawArrow({axes.X_WA.translation, axes.X_WA.rotate(along), glm::vec3(color)}, view, opacity);
    }
  }
  glDepthMask(GL_FALSE);
}

void OverlayPainter::DrawArrow(const view::Arrow& arrow, const View& view, float opacity) const {
  const auto length_m = static_cast<float>(glm::length(arrow.vector_W));
  if (length_m <= 0.0f) return;
  const glm::vec3 p_W(arrow.p_WTail);
  const glm::vec3 z(glm::normalize(arrow.vector_W));
  const glm::mat3 R_WA = FrameOf(z);
  // The radius is proportional to the distance, so the thickness on the screen is constant.
  const float radius_m = std::min(0.0025f * glm::distance(p_W, view.eye_W), 0.08f * length_m);
  const float head_m = std::min(9.0f * radius_m, 0.5f * length_m);
  SetColor(arrow.color, opacity);
  DrawBody(shaft_, p_W, R_WA, radius_m, length_m - head_m);
  DrawBody(head_, p_W + (length_m - head_m) * z, R_WA, 2.8f * radius_m, head_m);
}

void OverlayPainter::DrawRing(const view::RingArrow& ring, const View& view, float opacity) const {
  glm::mat4 X_WR(FrameOf(glm::vec3(ring.axis_W)));
  X_WR[3] = glm::vec4(glm::vec3(ring.p_WCentre), 1.0f);
  SetUniform(0, X_WR);
  const auto radius_m = static_cast<float>(ring.radius_m);
  const float tube_m = std::min(0.0025f * glm::distance(glm::vec3(ring.p_WCentre), view.eye_W), 0.1f * radius_m);
  glUniform3f(5, radius_m, tube_m, static_cast<float>(ring.sweep_rad));
  SetColor(ring.color, opacity);
  DrawMesh(tube_);
}

void OverlayPainter::DrawLine(const view::LineStrip& line, const View& view, const Film& film, float opacity) {
  if (line.p_W == nullptr || line.p_W->size() < 2) return;
  const std::size_t num_bytes = line.p_W->size() * sizeof(glm::vec3);
  Reserve(line.p_W->size());
  glNamedBufferSubData(strip_points_.id(), 0, static_cast<GLsizeiptr>(num_bytes), line.p_W->data());
  glUseProgram(line_.id());
  SetUniform(0, view.clip_W);
  const auto width = static_cast<float>(film.width()), height = static_cast<float>(film.height());
  glUniform3f(1, 0.5f * width, 0.5f * height, 0.5f * line.width_px * height / 360.0f);
  SetColor(line.color / view.exposure, opacity * line.opacity);
  glBindVertexArray(strip_layout_.id());
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(line.p_W->size()) - 1);
}

void OverlayPainter::DrawPoints(const view::PointSet& set, const View& view, const Film& film, float opacity) {
  if (set.p_P == nullptr || set.p_P->empty()) return;
  const std::size_t num_bytes = set.p_P->size() * sizeof(glm::vec3);
  Reserve(set.p_P->size());
  glNamedBufferSubData(strip_points_.id(), 0, static_cast<GLsizeiptr>(num_bytes), set.p_P->data());
  const bool is_colored = set.colors != nullptr && set.colors->size() == set.p_P->size();
  if (is_colored) {
    glNamedBufferSubData(strip_colors_.id(), 0, static_cast<GLsizeiptr>(num_bytes), set.colors->data());
  }
  glUseProgram(point_.id());
  SetUniform(0, view.clip_W * ToMatrix(set.X_WP));
  const auto height = static_cast<float>(film.height());
  glUniform2f(1, set.size_px * height / 360.0f, 0.5f * height * view.clip_per_up * set.most_m);
  glUniform2f(2, 1.0f / view.exposure, opacity);
  const GLuint layout = set_layout_.id();
  is_colored ? glEnableVertexArrayAttrib(layout, 1) : glDisableVertexArrayAttrib(layout, 1);
  glBindVertexArray(layout);
  if (!is_colored) glVertexAttrib3fv(1, glm::value_ptr(set.color));
  glEnable(GL_PROGRAM_POINT_SIZE);
  glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(set.p_P->size()));
  glDisable(GL_PROGRAM_POINT_SIZE);
}

void OverlayPainter::UseGrains(const GlProgram& program, const core::Pose& X_WP, const View& view,
                               const glm::vec4& color) const {
  glUseProgram(program.id());
  SetUniform(0, view.clip_W * ToMatrix(X_WP));
  const glm::vec3 eye_P(X_WP.inverse() * glm::dvec3(view.eye_W));
  glUniform3fv(1, 1, glm::value_ptr(eye_P));
  SetColor(glm::vec3(color) / view.exposure, color.a);
}

void OverlayPainter::DrawGrains(const void* grains, std::size_t count, std::size_t stride_bytes) {
  Reserve(count * stride_bytes / sizeof(glm::vec3) + 1);
  glNamedBufferSubData(strip_points_.id(), 0, static_cast<GLsizeiptr>(count * stride_bytes), grains);
  const GLuint layout = grain_layout_.id();
  glVertexArrayAttribFormat(layout, 0, static_cast<GLint>(stride_bytes / sizeof(float)), GL_FLOAT, GL_FALSE, 0);
  glVertexArrayVertexBuffer(layout, 0, strip_points_.id(), 0, static_cast<GLsizei>(stride_bytes));
  glBindVertexArray(layout);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(count));
}

void OverlayPainter::DrawCubes(const view::Cubes& cubes, const View& view) {
  if (cubes.p_P == nullptr || cubes.p_P->empty()) return;
  UseGrains(cube_, cubes.X_WP, view, glm::vec4(cubes.color, 1.0f));
  const auto half_m = 0.5f * static_cast<float>(cubes.edge_m);
  glUniform2f(3, half_m, 1.7321f);  // the sphere around a cube
  DrawGrains(cubes.p_P->data(), cubes.p_P->size(), sizeof(glm::vec3));
}

void OverlayPainter::DrawSpheres(const view::Spheres& spheres, const View& view) {
  if (spheres.p_P_radius_m == nullptr || spheres.p_P_radius_m->empty()) return;
  UseGrains(sphere_, spheres.X_WP, view, glm::vec4(spheres.color, spheres.opacity));
  glUniform2f(3, 1.0f, 1.0f);
  DrawGrains(spheres.p_P_radius_m->data(), spheres.p_P_radius_m->size(), sizeof(glm::vec4));
}

void OverlayPainter::Reserve(std::size_t num_points) {
  if (num_points <= capacity_points_) return;
  capacity_points_ = 2 * num_points;
  const std::size_t num_bytes = capacity_points_ * sizeof(glm::vec3);
  strip_points_ = MakeBuffer(nullptr, num_bytes);
  strip_colors_ = MakeBuffer(nullptr, num_bytes);
  constexpr GLsizei kStride = sizeof(glm::vec3);
  glVertexArrayVertexBuffer(strip_layout_.id(), 0, strip_points_.id(), 0, kStride);
  glVertexArrayVertexBuffer(strip_layout_.id(), 1, strip_points_.id(), kStride, kStride);
  glVertexArrayVertexBuffer(set_layout_.id(), 0, strip_points_.id(), 0, kStride);
  glVertexArrayVertexBuffer(set_layout_.id(), 1, strip_colors_.id(), 0, kStride);
}

void OverlayPainter::DrawPhantoms(const view::Scene& scene, const std::vector<GpuMesh>& meshes, const View& view,
                                  const Film& film) {
  const std::vector<view::Phantom> phantoms = AllPhantoms(scene, meshes);
  if (phantoms.empty()) return;
  const GLuint framebuffer = framebuffer_.id();
  if (width_ != film.width() || height_ != film.height()) {
    width_ = film.width();
    height_ = film.height();
    sum_ = MakeTexture(GL_RGBA16F, width_, height_);
    seen_ = MakeTexture(GL_R16F, width_, height_);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, sum_.id(), 0);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT1, seen_.id(), 0);
    const GLenum both[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glNamedFramebufferDrawBuffers(framebuffer, 2, both);
  }
  glNamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, film.depth(), 0);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  const float none[4] = {}, all[4] = {1.0f, 1.0f, 1.0f, 1.0f};
  glClearBufferfv(GL_COLOR, 0, none);
  glClearBufferfv(GL_COLOR, 1, all);
  glBlendFunci(0, GL_ONE, GL_ONE);
  glBlendFunci(1, GL_ZERO, GL_ONE_MINUS_SRC_COLOR);
  // A phantom that coincides with its part lies in front of it.
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(-1.0f, -2.0f);
  UseBodies(phantom_, view);
  for (const view::Phantom& phantom : phantoms) {
    const GpuMesh& mesh = meshes[scene.instances[phantom.instance].mesh];
    if (mesh.num_indices == 0) continue;
    SetUniform(0, ToMatrix(phantom.X_WM));
    SetColor(phantom.color, phantom.opacity);
    DrawMesh(mesh);
  }
  glDisable(GL_POLYGON_OFFSET_FILL);

  glBindFramebuffer(GL_FRAMEBUFFER, film.framebuffer());
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glDisable(GL_DEPTH_TEST);
  glUseProgram(mix_.id());
  glBindTextureUnit(0, sum_.id());
  glBindTextureUnit(1, seen_.id());
  glBindVertexArray(nothing_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
}

}  // namespace visual_node
