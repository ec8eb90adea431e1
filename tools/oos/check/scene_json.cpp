#include "tools/oos/check/scene_json.hpp"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "nodes/logic_node/logic_node.hpp"
#include "nodes/logic_node/node_loop.hpp"
#include "nodes/logic_node/procedure.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace oos {
namespace {

using nlohmann::json;

json Numbers(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

json Numbers(const glm::vec3& v) {
  return {v.x, v.y, v.z};
}

json Numbers(const core::Pose& X_AB) {
  const glm::dquat& q = X_AB.rotation;
  const glm::dvec3& p = X_AB.translation;
  return {q.w, q.x, q.y, q.z, p.x, p.y, p.z};
}

const char* NameOf(scene::Owner owner) {
  switch (owner) {
    case scene::Owner::kFixed:
      return "fixed";
    case scene::Owner::kPhysics:
      return "physics";
    case scene::Owner::kHand:
      return "hand";
  }
  return "";
}

const char* NameOf(scene::HandPart part) {
  switch (part) {
    case scene::HandPart::kNone:
      return "";
    case scene::HandPart::kPalm:
      return "palm";
    case scene::HandPart::kJawLeft:
      return "jaw_left";
    case scene::HandPart::kJawRight:
      return "jaw_right";
  }
  return "";
}

json MeshJson(const vps::VisualMesh& mesh) {
  json parts = json::array();
  for (const vps::VisualPrimitive& primitive : mesh.primitives) {
    json positions = json::array();
    for (const glm::vec3& p : primitive.positions) {
      for (int axis = 0; axis < 3; ++axis) positions.push_back(std::round(p[axis] * 1e6) * 1e-6);  // to the micrometre
    }
    parts.push_back({{"base_color", Numbers(primitive.base_color)},
                     {"positions", std::move(positions)},
                     {"indices", primitive.indices}});
  }
  return parts;
}

json ObjectJson(const scene::Object& object) {
  json row = {{"name", object.name},
              {"owner", NameOf(object.owner)},
              {"X_WO", Numbers(object.X_WO)},
              {"is_lamp", object.is_lamp}};
  if (object.material.is_given) row["base_color"] = Numbers(object.material.base_color);
  if (object.owner == scene::Owner::kHand) {
    row["part"] = NameOf(object.part);
    row["role_index"] = object.role;
  }
  if (object.sheet) row["sheet_color"] = Numbers(object.sheet->material.base_color);
  return row;
}

}  // namespace

core::Result<json> SceneJson(const scene::Scenario& scenario) {
  json scene = {{"name", scenario.name},    {"title", scenario.title}, {"file", scenario.file.string()},
                {"objects", json::array()}, {"hands", json::array()},  {"cameras", json::array()},
                {"steps", json::array()}};
  std::map<std::filesystem::path, std::size_t> places;
  for (const scene::Object& object : scenario.objects) {
    json row = ObjectJson(object);
    if (!object.visual_mesh.empty()) {
      const auto [place, is_new] = places.try_emplace(object.visual_mesh, scene["meshes"].size());
      row["mesh"] = place->second;
      if (is_new) {
        const auto mesh = vps::LoadVisualMesh(object.visual_mesh);
        if (!mesh) return core::Fail(mesh.error().code, mesh.error().detail);
        scene["meshes"].push_back(MeshJson(*mesh));
      }
    }
    scene["objects"].push_back(std::move(row));
  }
  for (const scene::Device& device : scenario.devices) {
    scene["hands"].push_back(
        {{"role", device.role}, {"X_WD", Numbers(device.X_WD_start)}, {"opening_m", device.opening_start_m}});
  }
  for (const scene::Camera& camera : scenario.cameras) {
    scene["cameras"].push_back({{"name", camera.name},
                                {"eye_m", Numbers(camera.eye_m)},
                                {"target_m", Numbers(camera.target_m)},
                                {"vertical_fov_rad", camera.vertical_fov_rad}});
    if (camera.object < 0) continue;
    const std::string& object = scenario.objects[static_cast<std::size_t>(camera.object)].name;
    scene["cameras"].back()[camera.is_mounted ? "mounted_on" : "follows"] = object;
  }
  if (const auto logic = logic_node::LogicNode::Create(scenario)) {
    for (const logic_node::StepRecord& step : (*logic)->steps()) scene["steps"].push_back(step.name);
  }
  scene["parameters"] = json::array();  // those that a session can change
  for (const std::string& name : logic_node::ParameterNames(scenario)) {
    const std::string owner = logic_node::OwnerOf(scenario, name);
    if (!owner.empty()) scene["parameters"].push_back(owner + "." + name);
  }
  return scene;
}

}  // namespace oos
