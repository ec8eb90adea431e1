#include "scene/read_scenario.hpp"
#include "scene/xml_numbers.hpp"

namespace scene {
namespace {

// A left hand is a right one in a mirror, the plane y = 0 of the palm: M = diag(1, -1, 1). A link's frame is then
// R' = M R S with S = diag(1, 1, -1), which keeps it right-handed. S commutes with a turn about z, so that joints have
// the same angles on both hands, and it is why a link's mesh is its own mirror image in its plane z = 0.
core::Pose Mirrored(const core::Pose& X) {
  const glm::dmat3 M = glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, 1);
  const glm::dmat3 S = glm::dmat3(1, 0, 0, 0, 1, 0, 0, 0, -1);
  return {glm::normalize(glm::quat_cast(M * glm::mat3_cast(X.rotation) * S)), M * X.translation};
}

class FingerExpander {
 public:
  FingerExpander(const std::filesystem::path& file, XmlElement* root, std::vector<Diagnostic>* diagnostics)
      : file_(file), root_(root), diagnostics_(diagnostics) {}

  void Expand() {
    std::vector<XmlElement> hands;
    for (const XmlElement& element : root_->children) {
      if (element.name == "fingers") hands.push_back(element);
    }
    for (const XmlElement& hand : hands) ExpandOne(hand);
  }

 private:
  void ExpandOne(const XmlElement& fingers) {
    const XmlElement* device = nullptr;
    const XmlElement* palm = nullptr;
    const std::string role = fingers.Get("role");
    for (const XmlElement& element : root_->children) {
      if (element.Get("role") != role) continue;
      if (element.name == "device") device = &element;
      if (element.name == "object" && element.Get("part") == "palm") palm = &element;
    }
    if (device == nullptr || palm == nullptr) {
      diagnostics_->push_back(
          {{file_, fingers.LineOf("role")},
           "fingers of role '" + role + "': there is no " + (device == nullptr ? "device" : "palm") + " with that role",
           "fingers are mounted on the palm of a device's hand",
           "add a <device role=\"" + role + "\"> and an <object owner=\"hand\" part=\"palm\" role=\"" + role +
               "\">, or correct the role"});
      return;
    }
    const std::filesystem::path file = (file_.parent_path() / fingers.Get("hand")).lexically_normal();
    auto hand = ReadXml(file);
    if (!hand) {
      diagnostics_->insert(diagnostics_->end(), hand.error().begin(), hand.error().end());
      return;
    }
    const std::size_t num_before = diagnostics_->size();
    CheckAgainstRules(*hand, file, diagnostics_, "hand");
    if (diagnostics_->size() != num_before) return;
    const Mount mount{fingers,
                      *hand,
                      std::filesystem::absolute(file).parent_path(),
                      ElementReader(*device).Pose(),
                      palm->Get("name"),
                      palm->Get("group", palm->Get("name"))};
    for (std::size_t i = 0; i < hand->children.size(); ++i) AddFinger(mount, i);
  }

  struct Mount {
    const XmlElement& fingers;
    const XmlElement& hand;
    std::filesystem::path folder;  // of the hand's file, to which its meshes are relative
    core::Pose X_WPalm;
    std::string palm;
    std::string group;
    [[nodiscard]] bool is_left() const { return fingers.Get("side") == "left"; }
    [[nodiscard]] std::string role() const { return fingers.Get("role"); }
  };

  // The mirror image of a chain of frames is that of each frame in the palm: X' of a link in the palm's frame is
  // Mirrored(X), so nothing is mirrored twice along the chain.
  void AddFinger(const Mount& mount, std::size_t finger) {
    const XmlElement& element = mount.hand.children[finger];
    core::Pose X_PalmL;
    std::string parent = mount.palm;
    for (std::size_t i = 0; i < element.children.size(); ++i) {
      const XmlElement& joint = element.children[i];
      double start_rad = 0.0;
      ElementReader(joint).Degrees("start_deg", &start_rad);
      const core::Pose X_PalmJ = X_PalmL * ElementReader(joint).Pose();
      X_PalmL = X_PalmJ * core::Pose{glm::angleAxis(start_rad, glm::dvec3(0, 0, 1)), glm::dvec3(0.0)};
      const core::Pose X_WJ = mount.X_WPalm * (mount.is_left() ? Mirrored(X_PalmJ) : X_PalmJ);
      const std::string name = mount.role() + "_" + element.Get("name") + "_" + std::to_string(i + 1);
      AddObject(mount, joint, name, finger, X_WJ);
      AddHinge(mount, joint, name, parent, finger * kJointsPerFinger + i, X_WJ);
      parent = name;
    }
  }

  void AddObject(const Mount& mount, const XmlElement& joint, const std::string& name, std::size_t finger,
                 const core::Pose& X_WJ) {
    XmlElement object;
    object.name = "object";
    object.line = mount.fingers.line;
    SetAttribute(&object, "name", name);
    SetAttribute(&object, "owner", "physics");
    SetAttribute(&object, "group", mount.group);
    SetPose(&object, X_WJ);
    CopyAttributes(joint, {"mass_kg", "inertia_kg_m2", "center_of_mass_m"}, &object);
    SetAttribute(&object, "finger_role", mount.role());
    SetAttribute(&object, "finger", std::to_string(finger));
    CopyAttributes(mount.hand, {"friction", "stiffness_N_per_m", "damping_N_s_per_m"}, &object);
    object.children = joint.children;
    for (XmlElement& child : object.children) {
      for (XmlAttribute& attribute : child.attributes) {
        if (attribute.name == "mesh") attribute.value = (mount.folder / attribute.value).string();
      }
    }
    root_->children.push_back(std::move(object));
  }

  void AddHinge(const Mount& mount, const XmlElement& joint, const std::string& name, const std::string& parent,
                std::size_t finger_joint, const core::Pose& X_WJ) {
    XmlElement hinge;
    hinge.name = "hinge";
    hinge.line = mount.fingers.line;
    SetAttribute(&hinge, "name", name + "_joint");
    SetAttribute(&hinge, "parent", parent);
    SetAttribute(&hinge, "child", name);
    SetPose(&hinge, X_WJ);
    CopyAttributes(joint, {"lower_deg", "upper_deg", "start_deg", "servo_Nm_per_rad", "servo_Nm_s_per_rad"}, &hinge);
    SetAttribute(&hinge, "motor_torque_Nm", joint.Get("torque_Nm"));
    SetAttribute(&hinge, "finger_role", mount.role());
    SetAttribute(&hinge, "finger_joint", std::to_string(finger_joint));
    root_->children.push_back(std::move(hinge));
  }

  const std::filesystem::path& file_;
  XmlElement* root_;
  std::vector<Diagnostic>* diagnostics_;
};

}  // namespace

void ExpandFingers(const std::filesystem::path& file, XmlElement* root, std::vector<Diagnostic>* diagnostics) {
  FingerExpander(file, root, diagnostics).Expand();
}

}  // namespace scene
