#include "tools/oos/record/view_export.hpp"

#include <algorithm>
#include <string_view>

#include "bus/topics.hpp"
#include "bus/wire/schema.hpp"
#include "proto/logic.pb.h"
#include "vps/mesh/load_mesh.hpp"

namespace oos {
namespace {

constexpr const char* kWorld = "world";
constexpr double kShaft_m = 0.004;  // diameter of an arrow's shaft; its head is twice as wide
constexpr double kHead = 0.3;       // of the arrow's length

void SetTime(std::int64_t time_ns, google::protobuf::Timestamp* stamp) {
  stamp->set_seconds(time_ns / 1'000'000'000);
  stamp->set_nanos(static_cast<std::int32_t>(time_ns % 1'000'000'000));
}

template <class Vector>  // foxglove::Vector3 or Point3
void SetVector(const glm::dvec3& v, Vector* to) {
  to->set_x(v.x);
  to->set_y(v.y);
  to->set_z(v.z);
}

void SetRotation(const glm::dquat& q, foxglove::Quaternion* to) {
  to->set_x(q.x);
  to->set_y(q.y);
  to->set_z(q.z);
  to->set_w(q.w);
}

void SetColor(const glm::vec3& color, foxglove::Color* to) {
  to->set_r(color.r);
  to->set_g(color.g);
  to->set_b(color.b);
  to->set_a(1.0);
}

void SetIdentity(foxglove::Pose* pose) {
  SetVector(glm::dvec3(0.0), pose->mutable_position());
  SetRotation(glm::dquat(1.0, 0.0, 0.0, 0.0), pose->mutable_orientation());
}

// The rotation of the smallest angle that brings x to a direction.
glm::dquat FromX(const glm::dvec3& direction) {
  const glm::dvec3 d = glm::normalize(direction);
  if (d.x < -1.0 + 1e-9) return {0.0, 0.0, 0.0, 1.0};  // half a turn about z
  const glm::dvec3 axis = glm::cross(glm::dvec3(1.0, 0.0, 0.0), d);
  return glm::normalize(glm::dquat(1.0 + d.x, axis.x, axis.y, axis.z));
}

foxglove::SceneEntity EntityOf(const std::string& id, const std::string& frame, bool is_locked, std::int64_t now_ns) {
  foxglove::SceneEntity entity;
  SetTime(now_ns, entity.mutable_timestamp());
  entity.set_id(id);
  entity.set_frame_id(frame);
  entity.set_frame_locked(is_locked);
  return entity;
}

void AddTriangles(const vps::VisualPrimitive& primitive, const glm::vec3& color, foxglove::SceneEntity* entity) {
  foxglove::TriangleListPrimitive* triangles = entity->add_triangles();
  SetIdentity(triangles->mutable_pose());
  SetColor(color, triangles->mutable_color());
  for (const glm::vec3& p : primitive.positions) SetVector(p, triangles->add_points());
  for (const std::uint32_t index : primitive.indices) triangles->add_indices(index);
}

// Two triangles for each cell of the grid of nodes.
void AddSheet(const view::Sheet& sheet, foxglove::SceneEntity* entity) {
  foxglove::TriangleListPrimitive* triangles = entity->add_triangles();
  SetIdentity(triangles->mutable_pose());
  SetColor(sheet.material.base_color, triangles->mutable_color());
  for (const glm::vec3& p : sheet.p_W) SetVector(p, triangles->add_points());
  const std::uint32_t columns = sheet.num_columns;
  const auto rows = columns == 0 ? 0U : static_cast<std::uint32_t>(sheet.p_W.size()) / columns;
  for (std::uint32_t row = 0; row + 1 < rows; ++row) {
    for (std::uint32_t column = 0; column + 1 < columns; ++column) {
      const std::uint32_t at = row * columns + column;
      for (const std::uint32_t i : {at, at + 1, at + columns, at + 1, at + columns + 1, at + columns}) {
        triangles->add_indices(i);
      }
    }
  }
}

bool IsFault(std::string_view event) {
  return event == "node_lost" || event == "node_stalled" || event.find("fault") != std::string_view::npos ||
         event.find("dropped") != std::string_view::npos || event.find("faded") != std::string_view::npos ||
         event.find("evicted") != std::string_view::npos;
}

}  // namespace

ViewExport::ViewExport(const scene::Scenario& scenario, bus::log::McapWriter* to)
    : scenario_(scenario), to_(to), mirror_(scenario) {
  const foxglove::SceneUpdate scene;
  models_ = AddOutput("/scene/models", scene);
  lamps_ = AddOutput("/scene/lamps", scene);
  contacts_ = AddOutput("/scene/contacts", scene);
  sheets_ = AddOutput("/scene/sheets", scene);
  frames_ = AddOutput("/tf", foxglove::FrameTransforms());
  log_ = AddOutput("/log", foxglove::Log());
}

ViewExport::Output ViewExport::AddOutput(const std::string& topic, const google::protobuf::Message& prototype) {
  const std::string name = prototype.GetTypeName();
  const auto [schema, is_new] = schemas_.try_emplace(name, std::uint16_t{0});
  if (is_new) {
    const std::string descriptors = bus::DescriptorSetOf(*prototype.GetDescriptor());
    schema->second = to_->AddSchema(name, "protobuf", bus::log::Bytes(descriptors.begin(), descriptors.end()));
  }
  return {to_->AddChannel(schema->second, topic, "protobuf", {{"tap", "derived"}}), 0};
}

core::Result<void> ViewExport::Write(Output* output, const google::protobuf::Message& message, std::int64_t now_ns) {
  const auto time = static_cast<std::uint64_t>(now_ns);
  const std::string bytes = message.SerializeAsString();
  ++num_messages_;
  return to_->Write(
      bus::log::Message{output->channel, ++output->sequence, time, time, bus::log::Bytes(bytes.begin(), bytes.end())});
}

core::Result<void> ViewExport::Begin(std::int64_t now_ns) {
  const view::Scene& scene = mirror_.scene();
  foxglove::SceneUpdate update;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const view::Instance& instance = scene.instances[i];
    const std::string& name = scene.assets->instance_names[i];
    if (!instance.is_visible) continue;
    const auto mesh = vps::LoadVisualMesh(scene.assets->meshes[instance.mesh]);
    if (!mesh) return core::Fail(mesh.error().code, mesh.error().detail);
    foxglove::SceneEntity entity = EntityOf(name, name, true, now_ns);
    for (const vps::VisualPrimitive& primitive : mesh->primitives) {
      const bool is_own = primitive.has_material && !instance.is_material_given;
      AddTriangles(primitive, is_own ? primitive.base_color : instance.material.base_color, &entity);
    }
    const bool is_lamp =
        std::any_of(scene.lamps.begin(), scene.lamps.end(), [i](const view::Lamp& lamp) { return lamp.instance == i; });
    if (is_lamp) {
      lamp_entities_[static_cast<std::uint32_t>(i)] = std::move(entity);
    } else {
      *update.add_entities() = std::move(entity);
    }
  }
  return Write(&models_, update, now_ns);
}

core::Result<void> ViewExport::WriteFrames(std::int64_t now_ns) {
  const view::Scene& scene = mirror_.scene();
  foxglove::FrameTransforms update;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const core::Pose& X_WM = scene.instances[i].X_WM;
    foxglove::FrameTransform* transform = update.add_transforms();
    SetTime(now_ns, transform->mutable_timestamp());
    transform->set_parent_frame_id(kWorld);
    transform->set_child_frame_id(scene.assets->instance_names[i]);
    SetVector(X_WM.translation, transform->mutable_translation());
    SetRotation(X_WM.rotation, transform->mutable_rotation());
  }
  return Write(&frames_, update, now_ns);
}

core::Result<void> ViewExport::WriteContacts(std::int64_t now_ns) {
  const view::Scene& scene = mirror_.scene();
  if (scene.arrows.empty() && !had_arrows_) return {};
  had_arrows_ = !scene.arrows.empty();
  foxglove::SceneUpdate update;
  foxglove::SceneEntity* entity = update.add_entities();
  *entity = EntityOf("contacts", kWorld, false, now_ns);
  for (const view::Arrow& arrow : scene.arrows) {
    const double length_m = glm::length(arrow.vector_W);
    if (!(length_m > 0.0)) continue;
    foxglove::ArrowPrimitive* primitive = entity->add_arrows();
    SetVector(arrow.p_WTail, primitive->mutable_pose()->mutable_position());
    SetRotation(FromX(arrow.vector_W), primitive->mutable_pose()->mutable_orientation());
    primitive->set_shaft_length((1.0 - kHead) * length_m);
    primitive->set_shaft_diameter(kShaft_m);
    primitive->set_head_length(kHead * length_m);
    primitive->set_head_diameter(2.0 * kShaft_m);
    SetColor(arrow.color, primitive->mutable_color());
  }
  return Write(&contacts_, update, now_ns);
}

core::Result<void> ViewExport::WriteSheets(std::int64_t now_ns) {
  const view::Scene& scene = mirror_.scene();
  const bool are_new = sheet_versions_.empty();
  sheet_versions_.resize(scene.sheets.size());
  foxglove::SceneUpdate update;
  for (std::size_t i = 0; i < scene.sheets.size(); ++i) {
    if (!are_new && scene.sheets[i].version == sheet_versions_[i]) continue;
    sheet_versions_[i] = scene.sheets[i].version;
    foxglove::SceneEntity entity = EntityOf("sheet " + std::to_string(i), kWorld, false, now_ns);
    AddSheet(scene.sheets[i], &entity);
    *update.add_entities() = std::move(entity);
  }
  return update.entities().empty() ? core::Result<void>() : Write(&sheets_, update, now_ns);
}

core::Result<void> ViewExport::WriteLamps(std::int64_t now_ns) {
  const view::Scene& scene = mirror_.scene();
  std::vector<glm::vec3> colors;
  for (const view::Lamp& lamp : scene.lamps) colors.push_back(lamp.color);
  if (colors == lamp_colors_) return {};
  lamp_colors_ = colors;
  foxglove::SceneUpdate update;
  for (const view::Lamp& lamp : scene.lamps) {
    const auto entity = lamp_entities_.find(lamp.instance);
    if (entity == lamp_entities_.end()) continue;
    SetTime(now_ns, entity->second.mutable_timestamp());
    for (auto& triangles : *entity->second.mutable_triangles()) SetColor(lamp.color, triangles.mutable_color());
    *update.add_entities() = entity->second;
  }
  return Write(&lamps_, update, now_ns);
}

core::Result<void> ViewExport::WriteEvent(const bus::log::Message& message) {
  oos::Event event;
  if (!event.ParseFromArray(message.data.data(), static_cast<int>(message.data.size()))) return {};
  const auto now_ns = static_cast<std::int64_t>(message.log_time_ns);
  foxglove::Log line;
  SetTime(now_ns, line.mutable_timestamp());
  line.set_level(IsFault(event.name()) ? foxglove::Log::WARNING : foxglove::Log::INFO);
  line.set_name(event.source());
  line.set_message(event.detail().empty() ? event.name() : event.name() + ": " + event.detail());
  return Write(&log_, line, now_ns);
}

core::Result<void> ViewExport::Take(const bus::log::Channel& channel, const bus::log::Message& message) {
  // Messages that nodes received are copies of those that others sent.
  const auto tap = channel.metadata.find("tap");
  if (tap != channel.metadata.end() && tap->second != "sent") return {};
  if (channel.topic == bus::kEventTopic) return WriteEvent(message);
  feed_.Apply(channel, message, &mirror_);
  const auto now_ns = static_cast<std::int64_t>(message.log_time_ns);
  if (now_ns >= next_frame_ns_) {
    next_frame_ns_ = std::max(next_frame_ns_ + kFrames_ns, now_ns);
    if (auto done = WriteFrames(now_ns); !done) return done;
  }
  if (now_ns < next_overlay_ns_) return {};
  next_overlay_ns_ = std::max(next_overlay_ns_ + kOverlays_ns, now_ns);
  mirror_.Refresh(now_ns);
  if (auto done = WriteContacts(now_ns); !done) return done;
  if (auto done = WriteSheets(now_ns); !done) return done;
  return WriteLamps(now_ns);
}

}  // namespace oos
