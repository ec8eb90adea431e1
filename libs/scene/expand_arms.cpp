#include "scene/read_scenario.hpp"
#include "scene/xml_numbers.hpp"

namespace scene {
namespace {

class Expander {
 public:
  Expander(const std::filesystem::path& file, XmlElement* root, std::vector<Diagnostic>* diagnostics)
      : file_(file), root_(root), diagnostics_(diagnostics) {}

  void Expand() {
    std::vector<XmlElement> arms;
    for (const XmlElement& element : root_->children) {
      if (element.name == "arm") arms.push_back(element);
    }
    for (const XmlElement& arm : arms) ExpandOne(arm);
  }

 private:
  void ExpandOne(const XmlElement& arm) {
    const std::filesystem::path file = file_.parent_path() / arm.Get("links");
    const auto links = ReadXml(file);
    if (!links) {
      diagnostics_->insert(diagnostics_->end(), links.error().begin(), links.error().end());
      return;
    }
    CheckAgainstRules(*links, file, diagnostics_, "links");
    std::vector<double> start_deg;
    ParseNumbers(arm.Get("start_deg"), &start_deg);
    if (!start_deg.empty() && start_deg.size() != links->children.size()) {
      diagnostics_->push_back(
          {{file_, arm.LineOf("start_deg")},
           "arm '" + arm.Get("name") + "': start_deg has " + std::to_string(start_deg.size()) + " angles",
           "the arm has " + std::to_string(links->children.size()) + " joints",
           "give one angle for each joint, from the base outwards"});
      return;
    }
    start_deg.resize(links->children.size(), 0.0);
    core::Pose X_WL = ElementReader(arm).Pose();  // the previous link, at first the mount
    std::string parent = arm.Get("base");
    for (std::size_t i = 0; i < links->children.size(); ++i) {
      const XmlElement& link = links->children[i];
      const core::Pose X_WJ = X_WL * ElementReader(link).Pose();
      const std::string name = arm.Get("name") + "_" + std::to_string(i + 1);
      AddObject(arm, link, name, X_WJ);
      AddHinge(arm, link, name, parent, X_WJ, start_deg[i]);
      X_WL = X_WJ * core::Pose{glm::angleAxis(start_deg[i] * kRadPerDeg, glm::dvec3(0, 0, 1)), glm::dvec3(0.0)};
      parent = name;
    }
  }

  // Links are in the group of the arm's base, so that they are not tested against it or each other.
  std::string GroupOf(const XmlElement& arm) const {
    for (const XmlElement& element : root_->children) {
      if (element.name == "object" && element.Get("name") == arm.Get("base")) {
        return element.Get("group", element.Get("name"));
      }
    }
    return arm.Get("name");
  }

  void AddObject(const XmlElement& arm, const XmlElement& link, const std::string& name, const core::Pose& X_WJ) {
    XmlElement object;
    object.name = "object";
    object.line = arm.line;
    SetAttribute(&object, "name", name);
    SetAttribute(&object, "owner", "physics");
    SetAttribute(&object, "group", GroupOf(arm));
    SetPose(&object, X_WJ);
    CopyAttributes(link, {"mass_kg", "inertia_kg_m2", "center_of_mass_m"}, &object);
    object.children = link.children;
    root_->children.push_back(std::move(object));
  }

  void AddHinge(const XmlElement& arm, const XmlElement& link, const std::string& name, const std::string& parent,
                const core::Pose& X_WJ, double start_deg) {
    XmlElement hinge;
    hinge.name = "hinge";
    hinge.line = arm.line;
    SetAttribute(&hinge, "name", name + "_joint");
    SetAttribute(&hinge, "parent", parent);
    SetAttribute(&hinge, "child", name);
    SetPose(&hinge, X_WJ);
    SetAttribute(&hinge, "start_deg", NumberText(start_deg));
    CopyAttributes(link, {"lower_deg", "upper_deg", "damping", "motor_deg_per_s", "motor_torque_Nm", "locked"}, &hinge);
    root_->children.push_back(std::move(hinge));
  }

  const std::filesystem::path& file_;
  XmlElement* root_;
  std::vector<Diagnostic>* diagnostics_;
};

}  // namespace

void ExpandArms(const std::filesystem::path& file, XmlElement* root, std::vector<Diagnostic>* diagnostics) {
  Expander(file, root, diagnostics).Expand();
}

}  // namespace scene
