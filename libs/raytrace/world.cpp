#include "raytrace/world.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "view/appearance/foil.hpp"
#include "view/appearance/material.hpp"
#include "view/appearance/sheet_mesh.hpp"
#include "view/appearance/skin.hpp"

namespace raytrace {
namespace {

constexpr float kFoilTile_m = 0.25f;

// Tilts are from -1 to 1.
vps::VisualTexture Wrinkles() {
  vps::VisualTexture picture{view::kFoilSize, view::kFoilSize, {}, false};
  const auto code = [](float share) { return static_cast<std::uint8_t>(std::lround(255.0f * share)); };
  for (const glm::vec3& tilt : view::FoilTilts()) {
    for (const float share : {0.5f * tilt.x + 0.5f, 0.5f * tilt.y + 0.5f, tilt.z, 1.0f}) {
      picture.rgba.push_back(code(std::clamp(share, 0.0f, 1.0f)));
    }
  }
  return picture;
}

void CopyPositions(const std::vector<glm::vec3>& positions, void* buffer) {
  std::memcpy(buffer, positions.data(), positions.size() * sizeof(glm::vec3));
}

RTCGeometry MakeTriangles(RTCDevice device, const vps::VisualPrimitive& primitive, bool bends) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  if (bends) rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_REFIT);
  CopyPositions(primitive.positions, rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                             sizeof(glm::vec3), primitive.positions.size()));
  void* indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          3 * sizeof(std::uint32_t), primitive.indices.size() / 3);
  std::memcpy(indices, primitive.indices.data(), primitive.indices.size() / 3 * 3 * sizeof(std::uint32_t));
  rtcCommitGeometry(geometry);
  return geometry;
}

// How far (u, v) change over a metre of a triangle's surface.
float SpanPerMetre(const glm::vec3& e1, const glm::vec3& e2, const glm::vec2& uv1, const glm::vec2& uv2) {
  const float area = glm::length(glm::cross(e1, e2));
  return area > 0.0f ? std::sqrt(std::abs(uv1.x * uv2.y - uv1.y * uv2.x) / area) : 0.0f;
}

// The texture's axes on a triangle with the normal n, from how place and texture coordinates change along its edges
// [Schueler 2006]. The texture's y points upwards, v downwards.
glm::vec3 Bumped(const glm::vec3& bump, const glm::vec3& n, const glm::vec3& e1, const glm::vec3& e2,
                 const glm::vec2& uv1, const glm::vec2& uv2) {
  const glm::vec3 across_1 = glm::cross(e2, n), across_2 = glm::cross(n, e1);
  const glm::vec3 t_u = across_1 * uv1.x + across_2 * uv2.x, t_v = across_1 * uv1.y + across_2 * uv2.y;
  const float longest = std::max(std::max(glm::dot(t_u, t_u), glm::dot(t_v, t_v)), 1e-30f);
  // Edges that run clockwise, seen from where n points, turn both axes.
  const float shrink = (glm::dot(glm::cross(e1, e2), n) < 0.0f ? -1.0f : 1.0f) / std::sqrt(longest);
  return glm::normalize(shrink * (bump.x * t_u - bump.y * t_v) + bump.z * n);
}

view::Material MaterialOf(const view::Instance& instance, const vps::VisualMaterial& look, bool has_lens) {
  // Of a lamp with a lens only the lens shines.
  if (instance.is_material_given && (!has_lens || look.is_lens)) return instance.material;
  view::Material material = view::MaterialOf(look);
  if (!instance.is_material_given) material.emissive += instance.material.emissive;
  return material;
}

}  // namespace

World::World() : wrinkles_(Wrinkles()) {}

core::Result<std::unique_ptr<World>> World::Create(const view::Scene& scene, const MeshLoader& load_mesh) {
  std::unique_ptr<World> world(new World);
  if (auto grown = world->Grow(scene, load_mesh); !grown) return tl::unexpected(grown.error());
  return world;
}

World::~World() {
  for (const Placed& placed : placed_) rtcReleaseGeometry(placed.geometry);
  for (const Mesh& mesh : meshes_) rtcReleaseScene(mesh.tree);
  if (top_ != nullptr) rtcReleaseScene(top_);
  if (device_ != nullptr) rtcReleaseDevice(device_);
}

core::Result<void> World::Grow(const view::Scene& scene, const MeshLoader& load_mesh) {
  device_ = rtcNewDevice("threads=1");  // the other core belongs to the force loop
  if (device_ == nullptr) {
    return core::Fail(core::ErrorCode::kUnsupported,
                      "Embree does not start: error " + std::to_string(rtcGetDeviceError(nullptr)));
  }
  for (const std::filesystem::path& path : scene.assets->meshes) {
    if (path.empty()) {  // an invisible object
      Add({}, false);
      continue;
    }
    core::Result<vps::VisualMesh> mesh = load_mesh(path);
    if (!mesh) return tl::unexpected(mesh.error());
    const bool bends = !mesh->joints.empty();
    Add(std::move(*mesh), bends);
    if (bends) meshes_.back().skin = meshes_.back().source;
  }
  const std::size_t num_meshes = meshes_.size();
  for (const view::Sheet& sheet : scene.sheets) {
    Add({{view::MakeSheetMesh(sheet)}}, true);
    Mesh& mesh = meshes_.back();
    mesh.rest_positions = mesh.source.primitives[0].positions;
    mesh.rest_normals = mesh.source.primitives[0].normals;
    sheet_versions_.push_back(sheet.version);
  }
  top_ = rtcNewScene(device_);
  rtcSetSceneFlags(top_, RTC_SCENE_FLAG_DYNAMIC | RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(top_, RTC_BUILD_QUALITY_MEDIUM);
  num_instances_ = scene.instances.size();
  placed_.resize(num_instances_ + scene.sheets.size());
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const bool is_sheet = i >= num_instances_;
    placed_[i].mesh = is_sheet ? num_meshes + i - num_instances_ : scene.instances[i].mesh;
    if (!is_sheet && i < scene.assets->variants.size()) placed_[i].variant = scene.assets->variants[i];
    ids_.push_back(
        static_cast<std::uint16_t>((is_sheet ? scene.sheets[i - num_instances_].instance : i) + std::size_t{1}));
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, meshes_[placed_[i].mesh].tree);
    rtcSetGeometryMask(geometry, 0);
    const float unmoved[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, unmoved);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(top_, geometry, static_cast<unsigned>(i));
    placed_[i].geometry = geometry;
  }
  has_changed_ = true;
  if (const RTCError error = rtcGetDeviceError(device_); error != RTC_ERROR_NONE) {
    return core::Fail(core::ErrorCode::kUnsupported, "Embree cannot take the scene: error " + std::to_string(error));
  }
  Update(scene);
  return {};
}

void World::Add(vps::VisualMesh source, bool bends) {
  Mesh mesh;
  mesh.tree = rtcNewScene(device_);
  rtcSetSceneFlags(mesh.tree, bends ? RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC : RTC_SCENE_FLAG_ROBUST);
  glm::vec3 low(1e9f), high(-1e9f);
  for (std::size_t i = 0; i < source.primitives.size(); ++i) {
    const vps::VisualPrimitive& primitive = source.primitives[i];
    mesh.has_lens = mesh.has_lens || primitive.is_lens;
    for (const glm::vec3& p : primitive.positions) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    if (primitive.indices.size() < 3) continue;
    RTCGeometry geometry = MakeTriangles(device_, primitive, bends);
    rtcSetGeometryMask(geometry, kDrawn | kVisible | (primitive.transmission > 0.0f ? 0u : kBlocks));
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(mesh.tree, geometry, static_cast<unsigned>(i));
    rtcReleaseGeometry(geometry);  // the tree keeps it
  }
  rtcCommitScene(mesh.tree);
  ++num_mesh_builds_;
  if (low.x <= high.x) mesh.centre_M = 0.5f * (low + high);
  for (const vps::VisualPrimitive& primitive : source.primitives) {
    for (const glm::vec3& p : primitive.positions) {
      mesh.radius_m = std::max(mesh.radius_m, glm::distance(p, mesh.centre_M));
    }
  }
  for (const vps::VisualTexture& picture : source.textures) mesh.textures.emplace_back(picture);
  mesh.source = std::move(source);
  meshes_.push_back(std::move(mesh));
}

void World::Update(const view::Scene& scene) {
  for (std::size_t i = 0; i < num_instances_ && i < scene.instances.size(); ++i) {
    const view::Instance& instance = scene.instances[i];
    const bool is_drawn = instance.is_visible && instance.opacity >= 1.0f;
    Move(&placed_[i], instance.X_WM, (is_drawn ? kDrawn | kBlocks : 0u) | (instance.is_visible ? kVisible : 0u));
    const Mesh& mesh = meshes_[placed_[i].mesh];
    if (instance.posture != mesh.posture) Bend(instance.posture, &placed_[i]);
    placed_[i].materials.clear();
    for (const vps::VisualPrimitive& part : mesh.source.primitives) {
      placed_[i].materials.push_back(
          MaterialOf(instance, view::LookOf(part, mesh.source, placed_[i].variant), mesh.has_lens));
    }
    placed_[i].has_own_material = instance.is_material_given;
  }
  for (std::size_t i = 0; i < sheet_versions_.size() && i < scene.sheets.size(); ++i) {
    const view::Sheet& sheet = scene.sheets[i];
    Placed& placed = placed_[num_instances_ + i];
    if (sheet_versions_[i] != sheet.version) {
      sheet_versions_[i] = sheet.version;
      Bend(sheet, &placed);
    }
    Move(&placed, core::Pose(), sheet.is_visible ? kDrawn | kVisible | kBlocks : 0u);
    placed.materials = {sheet.material};
    placed.has_own_material = true;
  }
  if (has_changed_) rtcCommitScene(top_);
  has_changed_ = false;
}

void World::Move(Placed* placed, const core::Pose& X_WM, unsigned mask) {
  const bool is_there =
      placed->X_WM.translation == X_WM.translation && placed->X_WM.rotation == X_WM.rotation && placed->mask == mask;
  if (is_there) return;
  has_changed_ = true;
  placed->X_WM = X_WM;
  placed->mask = mask;
  placed->R_WM = glm::mat3(glm::mat3_cast(X_WM.rotation));
  placed->p_WM = glm::vec3(X_WM.translation);
  const glm::mat4x3 matrix(placed->R_WM[0], placed->R_WM[1], placed->R_WM[2], placed->p_WM);
  rtcSetGeometryTransform(placed->geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &matrix[0][0]);
  rtcSetGeometryMask(placed->geometry, mask);
  rtcCommitGeometry(placed->geometry);
}

void World::Bend(const view::Sheet& sheet, Placed* placed) {
  Mesh& mesh = meshes_[placed->mesh];
  mesh.source.primitives = {view::MakeSheetMesh(sheet)};
  Refit(placed);
}

void World::Bend(const view::Posture& posture, Placed* placed) {
  Mesh& mesh = meshes_[placed->mesh];
  if (posture == nullptr || posture->size() != mesh.skin.joints.size()) return;
  mesh.posture = posture;
  view::BendSkin(mesh.skin, *posture, &mesh.source);
  Refit(placed);
}

void World::Refit(Placed* placed) {
  const Mesh& mesh = meshes_[placed->mesh];
  for (std::size_t i = 0; i < mesh.source.primitives.size(); ++i) {
    RTCGeometry geometry = rtcGetGeometry(mesh.tree, static_cast<unsigned>(i));
    if (geometry == nullptr) continue;  // too small to have a triangle
    CopyPositions(mesh.source.primitives[i].positions, rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
  }
  rtcCommitScene(mesh.tree);
  rtcCommitGeometry(placed->geometry);  // its bounds are others
  ++num_mesh_builds_;
  has_changed_ = true;
}

std::vector<Lamp> World::ShiningLamps(const view::Scene& scene) const {
  std::vector<Lamp> lamps;
  for (const view::Lamp& lamp : scene.lamps) {
    const view::Instance& instance = scene.instances[lamp.instance];
    if (lamp.color == glm::vec3(0.0f) || !instance.is_visible || lamps.size() == kMaxLamps) continue;
    const Mesh& mesh = meshes_[instance.mesh];
    lamps.push_back({glm::vec3(instance.X_WM * glm::dvec3(mesh.centre_M)), 2.5f * mesh.radius_m, lamp.color});
  }
  return lamps;
}

Surface World::SurfaceAt(const Place& place) const {
  const Placed& placed = placed_[place.instance];
  const Mesh& mesh = meshes_[placed.mesh];
  const vps::VisualPrimitive& part = mesh.source.primitives[place.primitive];
  const vps::VisualMaterial& look = view::LookOf(part, mesh.source, placed.variant);
  const view::Material& material = placed.materials[place.primitive];
  const std::uint32_t* corner = &part.indices[std::size_t{3} * place.triangle];
  const std::uint32_t a = corner[0], b = corner[1], c = corner[2];
  const float w = 1.0f - place.u - place.v;
  const auto mean = [&](const auto& values) { return w * values[a] + place.u * values[b] + place.v * values[c]; };

  Surface s;
  const glm::vec3 p_M = mean(part.positions), e1 = part.positions[b] - part.positions[a],
                  e2 = part.positions[c] - part.positions[a];
  const glm::vec3 flat_M = glm::cross(e1, e2);
  const glm::vec3 along_M = place.along_W * placed.R_WM;
  const float side = glm::dot(flat_M, along_M) > 0.0f ? -1.0f : 1.0f;
  s.is_back = side < 0.0f;
  if (!placed.has_own_material) {
    s.transmission = part.transmission;
    s.ior = part.ior;
  }
  glm::vec3 n_M = side * mean(part.normals);
  n_M = glm::dot(n_M, n_M) > 0.0f ? glm::normalize(n_M) : side * glm::normalize(flat_M);
  s.v_W = -glm::normalize(place.along_W);
  s.base = material.base_color;
  s.emissive = material.emissive;
  s.metallic = material.metallic;
  s.roughness = material.roughness;
  s.is_foil = material.is_foil;
  s.coat = material.coat;
  s.coat_roughness = material.coat_roughness;
  s.smooth_n_W = placed.R_WM * n_M;
  s.n_W = s.smooth_n_W;
  s.p_W = placed.R_WM * p_M + placed.p_WM;

  // On the curved surface that the normals describe, not within the flat triangle that would shade it [Hanika 2021].
  glm::vec3 out_M = p_M;
  const float shares[3] = {w, place.u, place.v};
  for (std::size_t i = 0; i < 3; ++i) {
    const glm::vec3 n = side * part.normals[corner[i]];
    out_M -= shares[i] * std::min(glm::dot(p_M - part.positions[corner[i]], n), 0.0f) * n;
  }
  const float rounding_m = 1e-4f + 2e-6f * glm::length(s.p_W);
  s.p_WOut = placed.R_WM * (out_M + rounding_m * n_M) + placed.p_WM;

  const float slant = std::max(glm::dot(s.smooth_n_W, s.v_W), 0.05f);
  const float pixel_m = place.pixel_m / slant;
  const bool is_textured = !material.is_foil && !(placed.has_own_material && (!mesh.has_lens || look.is_lens)) &&
                           !part.uvs.empty() && !mesh.textures.empty();
  if (is_textured) {
    const glm::vec2 uv = mean(part.uvs), uv1 = part.uvs[b] - part.uvs[a], uv2 = part.uvs[c] - part.uvs[a];
    const float span = pixel_m * SpanPerMetre(e1, e2, uv1, uv2);
    const auto sample = [&](int texture) { return mesh.textures[static_cast<std::size_t>(texture)].At(uv, span); };
    if (look.base_texture >= 0) s.base *= sample(look.base_texture);
    if (look.surface_texture >= 0) {
      const glm::vec3 surface = sample(look.surface_texture);
      s.roughness *= surface.g;
      s.metallic *= surface.b;
      if (look.has_occlusion) s.open = surface.r;
    }
    if (look.emissive_texture >= 0) s.emissive *= sample(look.emissive_texture);
    if (look.normal_texture >= 0) {
      const glm::vec3 bump = sample(look.normal_texture) * (255.0f / 127.0f) - (128.0f / 127.0f);
      s.n_W = placed.R_WM * Bumped(bump, n_M, e1, e2, uv1, uv2);
    }
  }
  s.roughness = std::clamp(s.roughness, 0.06f, 1.0f);
  if (material.is_foil) Wrinkle(placed, part, corner, shares, pixel_m, &s);
  return s;
}

// As the surface shader does it: each point of the surface lies on the tile of the axis that it faces most.
void World::Wrinkle(const Placed& placed, const vps::VisualPrimitive& part, const std::uint32_t* corner,
                    const float* shares, float pixel_m, Surface* s) const {
  const Mesh& mesh = meshes_[placed.mesh];
  const bool bends = !mesh.rest_positions.empty();
  const auto& positions = bends ? mesh.rest_positions : part.positions;
  const auto& normals = bends ? mesh.rest_normals : part.normals;
  glm::vec3 p(0.0f), side(0.0f);
  for (std::size_t i = 0; i < 3; ++i) {
    p += shares[i] * positions[corner[i]];
    side += shares[i] * normals[corner[i]];
  }
  side = glm::abs(side);
  const bool is_x = side.x > side.y && side.x > side.z, is_y = !is_x && side.y > side.z;
  const glm::vec2 place = is_x ? glm::vec2(p.y, p.z) : (is_y ? glm::vec2(p.x, p.z) : glm::vec2(p.x, p.y));
  glm::vec3 along = is_x ? placed.R_WM[1] : placed.R_WM[0];
  glm::vec3 across = is_x || is_y ? placed.R_WM[2] : placed.R_WM[1];
  along -= s->n_W * glm::dot(s->n_W, along);
  across -= s->n_W * glm::dot(s->n_W, across);
  const glm::vec3 tilt =
      wrinkles_.At(place / kFoilTile_m, pixel_m / kFoilTile_m) * glm::vec3(2.0f, 2.0f, 1.0f) - glm::vec3(1, 1, 0);
  s->n_W = glm::normalize(s->n_W - tilt.x * along - tilt.y * across);
  s->along_W = along;
  const float a = s->roughness * s->roughness;
  const float within = std::max(tilt.z - tilt.x * tilt.x - tilt.y * tilt.y, 0.0f);  // of the wrinkles below a pixel
  s->roughness = std::pow(std::min(a * a + within, 1.0f), 0.25f);
}

}  // namespace raytrace
