#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>

#include "core/names.hpp"
#include "scene/element_reader.hpp"
#include "scene/read_scenario.hpp"
#include "scene/schema.hpp"

namespace scene {
namespace {

class SceneryReader {
 public:
  SceneryReader(const std::filesystem::path& file, Scenario* scenario, std::vector<Diagnostic>* diagnostics)
      : file_(file), scenario_(*scenario), diagnostics_(*diagnostics) {}

  void Read(const XmlElement& root) {
    for (const XmlElement& element : root.children) {
      if (element.name == "scenery") ReadScenery(element);
      if (element.name == "shown_arm") ReadArm(element);
    }
    for (const XmlElement& element : root.children) {
      if (element.name == "scenery") CheckJoints(element);
    }
  }

 private:
  void Report(const Location& where, std::string what, std::string why, std::string fix) {
    diagnostics_.push_back({where, std::move(what), std::move(why), std::move(fix)});
  }

  // Absolute path of a mesh, whose name is relative to `folder`.
  std::filesystem::path Mesh(const XmlElement& element, const Location& where, const std::filesystem::path& folder) {
    const std::filesystem::path path = (folder / element.Get("mesh")).lexically_normal();
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
      Report(where, "mesh '" + element.Get("mesh") + "' is missing", path.string() + " does not exist",
             "make the mesh (see the sources beside it) or correct the path");
    }
    return path;
  }

  void ReadScenery(const XmlElement& element) {
    const Location where{file_, element.line};
    scenario_.scenery.push_back({element.Get("name"), Mesh(element, where, scenario_.folder),
                                 ElementReader(element).Pose(), JointsOf(element), element.Get("variant")});
  }

  static std::vector<std::string> JointsOf(const XmlElement& element) {
    std::istringstream words(element.Get("joints"));
    return {std::istream_iterator<std::string>(words), {}};
  }

  // After all that a joint can go with has been read.
  void CheckJoints(const XmlElement& element) {
    std::vector<std::string> known;
    for (const Object& object : scenario_.objects) known.push_back(object.name);
    for (const ShownArm& arm : scenario_.shown_arms) {
      for (std::size_t i = 0; i < ShownArm::kNumLinks; ++i) known.push_back(arm.LinkName(i));
    }
    for (const std::string& joint : JointsOf(element)) {
      if (std::find(known.begin(), known.end(), joint) != known.end()) continue;
      Report({file_, element.line}, "scenery '" + element.Get("name") + "': nothing is called '" + joint + "'",
             "a joint goes with an object or with a link of a shown arm", core::SuggestName(joint, known));
    }
  }

  void ReadArm(const XmlElement& element) {
    const Location where{file_, element.line};
    const std::filesystem::path file = (scenario_.folder / element.Get("links")).lexically_normal();
    const auto links = ReadXml(file);
    if (!links) {
      diagnostics_.insert(diagnostics_.end(), links.error().begin(), links.error().end());
      return;
    }
    CheckAgainstRules(*links, file, &diagnostics_, "links");
    ShownArm arm;
    arm.name = element.Get("name");
    const std::string title = "shown_arm '" + arm.name + "': ";
    arm.X_WB = ElementReader(element).Pose();
    ElementReader(element).Vector("elbow", &arm.elbow_W);
    glm::dvec3 position_m(0.0), rpy_deg(0.0);
    ElementReader(element).Vector("flange_position", &position_m);
    ElementReader(element).Vector("flange_rpy_deg", &rpy_deg);
    arm.X_PalmF = {core::QuaternionFromRollPitchYaw(rpy_deg * kRadPerDeg), position_m};
    arm.role = scenario_.FindRole(element.Get("role"));
    if (arm.role < 0) {
      std::vector<std::string> roles;
      for (const Device& device : scenario_.devices) roles.push_back(device.role);
      Report(where, title + "no device has the role '" + element.Get("role") + "'",
             "its flange follows a device's hand", core::SuggestName(element.Get("role"), roles));
      return;
    }
    if (links->children.size() != ShownArm::kNumLinks) {
      Report(where, title + "it has " + std::to_string(links->children.size()) + " links",
             "its posture is that of seven", "give seven links, as scenarios/service_robot/arm.xml does");
      return;
    }
    for (std::size_t i = 0; i < ShownArm::kNumLinks; ++i) {
      const XmlElement& link = links->children[i];
      ReadLink(link, {file, link.line}, &arm.links[i], i + 1 == ShownArm::kNumLinks ? &arm.X_7F : nullptr);
      if (IsInTurn(arm.links[i].X_PJ, i)) continue;
      Report({file, link.line},
             title + "its joint " + std::to_string(i + 1) + " is not where a light-weight robot's is",
             "axes go along the arm and across it in turn, without offsets, so that the posture follows in closed form",
             "place it as scenarios/service_robot/arm.xml does");
    }
    scenario_.shown_arms.push_back(std::move(arm));
  }

  void ReadLink(const XmlElement& element, const Location& where, ShownArm::Link* link, core::Pose* X_7F) {
    link->X_PJ = ElementReader(element).Pose();
    for (const XmlElement& child : element.children) {
      if (child.name == "visual") {
        link->visual_mesh = Mesh(child, where, where.file.parent_path());
        link->material = ReadMaterial(child);
      }
      if (child.name == "frame" && child.Get("name") == "flange" && X_7F != nullptr)
        *X_7F = ElementReader(child).Pose();
    }
  }

  static bool IsInTurn(const core::Pose& X_PJ, std::size_t joint) {
    const double turn_deg = joint == 0 ? 0.0 : (joint % 2 == 1 ? 90.0 : -90.0);
    const glm::dquat expected = core::QuaternionFromRollPitchYaw({turn_deg * kRadPerDeg, 0.0, 0.0});
    const glm::dvec3& p = X_PJ.translation;
    const double along_m = joint > 0 && joint % 2 == 0 ? p.y : p.z;
    const bool has_length = along_m > 0.0 || joint == 0;
    return has_length && glm::length(p) - std::abs(along_m) < 1e-9 &&
           std::abs(glm::dot(expected, X_PJ.rotation)) > 1.0 - 1e-9;
  }

  const std::filesystem::path& file_;
  Scenario& scenario_;
  std::vector<Diagnostic>& diagnostics_;
};

}  // namespace

Material ReadMaterial(const XmlElement& visual) {
  const ElementReader read(visual);
  Material material;
  material.is_given = visual.Find("base_color") != nullptr;
  material.variant = visual.Get("variant");
  read.Vector("base_color", &material.base_color);
  double metallic = material.metallic, roughness = material.roughness;
  read.Number("metallic", &metallic);
  read.Number("roughness", &roughness);
  material.metallic = static_cast<float>(metallic);
  material.roughness = static_cast<float>(roughness);
  return material;
}

void ReadScenery(const XmlElement& root, const std::filesystem::path& file, Scenario* scenario,
                 std::vector<Diagnostic>* diagnostics) {
  SceneryReader(file, scenario, diagnostics).Read(root);
}

}  // namespace scene
