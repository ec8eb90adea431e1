#include <algorithm>

#include "core/names.hpp"
#include "scene/element_reader.hpp"
#include "scene/read_scenario.hpp"

namespace scene {
namespace {

constexpr std::size_t kMaxProfilePoints = 16;  // chosen: more than a measured profile of one barrier needs

class MechanismReader {
 public:
  MechanismReader(const std::filesystem::path& file, Scenario* scenario, std::vector<Diagnostic>* diagnostics)
      : file_(file), scenario_(scenario), diagnostics_(diagnostics) {}

  void Read(const XmlElement& element) {
    if (element.name == "hinge") ReadHinge(element);
    if (element.name == "slider") ReadSlider(element);
    if (element.name == "snap") ReadSnap(element);
    if (element.name == "hook_and_loop") ReadHookAndLoop(element);
  }

 private:
  void Report(int line, std::string what, std::string why, std::string fix) {
    diagnostics_->push_back({{file_, line}, std::move(what), std::move(why), std::move(fix)});
  }

  // Index of the object that an attribute names; -1, with a diagnostic, when there is none.
  int ObjectOf(const XmlElement& element, const char* attribute) {
    const std::string name = element.Get(attribute);
    const int index = scenario_->FindObject(name);
    if (index < 0 && !name.empty()) {
      std::vector<std::string> names;
      for (const Object& object : scenario_->objects) names.push_back(object.name);
      Report(element.LineOf(attribute), element.name + " '" + element.Get("name") + "': unknown object '" + name + "'",
             std::string(attribute) + " must name an <object> of this file", core::SuggestName(name, names));
    }
    return index;
  }

  core::Pose PoseOf(int object) const {
    return object < 0 ? core::Pose{} : scenario_->objects[static_cast<std::size_t>(object)].X_WO;
  }

  Mechanism Start(const XmlElement& element, MechanismKind kind) {
    Mechanism mechanism;
    mechanism.kind = kind;
    mechanism.location = {file_, element.line};
    mechanism.name = element.Get("name");
    mechanism.parent = ObjectOf(element, "parent");
    mechanism.child = ObjectOf(element, "child");
    ElementReader(element).Number("damping", &mechanism.damping);
    return mechanism;
  }

  // J is given in W with the child at angle 0: X_PJ = X_WP^-1 X_WJ and X_CJ = X_WC^-1 X_WJ. The child starts at an
  // angle q, which is the initial detent of a toggle switch, start_deg of another hinge: X_WC = X_WJ Rz(q) X_CJ^-1.
  void ReadHinge(const XmlElement& element) {
    const ElementReader read(element);
    Mechanism hinge = Start(element, MechanismKind::kHinge);
    const core::Pose X_WJ = read.Pose();
    hinge.X_PJ = PoseOf(hinge.parent).inverse() * X_WJ;
    hinge.X_CJ = PoseOf(hinge.child).inverse() * X_WJ;
    read.Degrees("lower_deg", &hinge.lower);
    read.Degrees("upper_deg", &hinge.upper);
    read.Degrees("motor_deg_per_s", &hinge.motor_speed);
    read.Number("motor_torque_Nm", &hinge.motor_limit);
    read.Boolean("locked", &hinge.is_locked);
    std::vector<double> detents_deg;
    ParseNumbers(element.Get("detents_deg"), &detents_deg);
    for (const double detent_deg : detents_deg) hinge.detents_rad.push_back(detent_deg * kRadPerDeg);
    read.Number("detent_torque_Nm", &hinge.detent_torque_Nm);
    const std::uint64_t initial_detent = read.Count("initial_detent", 0);
    hinge.initial_detent = static_cast<int>(std::min<std::uint64_t>(initial_detent, 1));
    if (element.Find("finger_role") != nullptr) {
      hinge.finger_role = scenario_->FindRole(element.Get("finger_role"));
      hinge.finger_joint = static_cast<int>(read.Count("finger_joint", 0));
      read.Number("servo_Nm_per_rad", &hinge.servo_stiffness_Nm_per_rad);
      read.Number("servo_Nm_s_per_rad", &hinge.servo_damping_Nm_s_per_rad);
      read.Degrees("start_deg", &hinge.start_rad);
    }
    CheckHinge(element, hinge, initial_detent);
    double angle_rad = 0.0;
    read.Degrees("start_deg", &angle_rad);
    if (hinge.detents_rad.size() == 2) {
      angle_rad = hinge.detents_rad[static_cast<std::size_t>(hinge.initial_detent)];
    }
    if (hinge.child >= 0) {
      const core::Pose X_JpJc{glm::angleAxis(angle_rad, glm::dvec3(0, 0, 1)), glm::dvec3(0.0)};
      scenario_->objects[static_cast<std::size_t>(hinge.child)].X_WO = X_WJ * X_JpJc * hinge.X_CJ.inverse();
    }
    scenario_->mechanisms.push_back(std::move(hinge));
  }

  void CheckAxis(const XmlElement& element, const Mechanism& joint, const char* lower, const char* speed,
                 const char* limit) {
    const std::string title = element.name + " '" + joint.name + "': ";
    if (joint.lower >= joint.upper) {
      Report(element.LineOf(lower), title + lower + " is not below the upper limit",
             "the " + element.name + " could not move", "swap the limits or widen them");
    }
    if (element.Find(speed) != nullptr && joint.motor_limit <= 0.0) {
      Report(element.LineOf(speed), title + speed + " without " + limit,
             "without a torque or force the motor has no effect", std::string("add ") + limit);
    }
  }

  // As for a hinge, J is given in W with the child at position 0, where it starts.
  void ReadSlider(const XmlElement& element) {
    const ElementReader read(element);
    Mechanism slider = Start(element, MechanismKind::kSlider);
    const core::Pose X_WJ = read.Pose();
    slider.X_PJ = PoseOf(slider.parent).inverse() * X_WJ;
    slider.X_CJ = PoseOf(slider.child).inverse() * X_WJ;
    read.Number("lower_m", &slider.lower);
    read.Number("upper_m", &slider.upper);
    read.Number("motor_m_per_s", &slider.motor_speed);
    read.Number("motor_force_N", &slider.motor_limit);
    read.Boolean("locked", &slider.is_locked);
    CheckAxis(element, slider, "lower_m", "motor_m_per_s", "motor_force_N");
    scenario_->mechanisms.push_back(std::move(slider));
  }

  void CheckHinge(const XmlElement& element, const Mechanism& hinge, std::uint64_t initial_detent) {
    const std::string title = "hinge '" + hinge.name + "': ";
    CheckAxis(element, hinge, "lower_deg", "motor_deg_per_s", "motor_torque_Nm");
    double start_rad = 0.0;
    ElementReader(element).Degrees("start_deg", &start_rad);
    if (hinge.detents_rad.empty() && (start_rad < hinge.lower || start_rad > hinge.upper)) {
      Report(element.LineOf("start_deg"), title + "it starts outside its limits",
             "the limit would accelerate it in the first step", "give a start_deg between lower_deg and upper_deg");
    }
    if (element.Find("start_deg") != nullptr && !hinge.detents_rad.empty()) {
      Report(element.LineOf("start_deg"), title + "start_deg on a switch", "a switch starts in its initial_detent",
             "remove start_deg");
    }
    const std::vector<double>& detents = hinge.detents_rad;
    if (!detents.empty() && detents.size() != 2) {
      Report(element.LineOf("detents_deg"), title + std::to_string(detents.size()) + " detents",
             "a hinge has either none or two, the stable positions of a switch",
             "give two angles or remove detents_deg");
    } else if (detents.size() == 2 && detents[0] >= detents[1]) {
      Report(element.LineOf("detents_deg"), title + "detents are not ascending", "detent 0 is the lower angle",
             "write the lower angle first");
    } else if (detents.size() == 2 && (detents[0] < hinge.lower || detents[1] > hinge.upper)) {
      Report(element.LineOf("detents_deg"), title + "a detent is outside the limits", "the lever cannot reach it",
             "widen lower_deg and upper_deg to hold both detents");
    }
    if (initial_detent > 1 || (initial_detent == 1 && detents.empty())) {
      Report(element.LineOf("initial_detent"), title + "initial_detent is " + std::to_string(initial_detent),
             "it is 0 or 1, the index in detents_deg", "write 0 or 1 and give two detents");
    }
  }

  // The frame of an object that an attribute names; null, with a diagnostic, when there is none.
  const Frame* FrameOf(const XmlElement& element, const char* attribute, int object_index) {
    if (object_index < 0) return nullptr;
    const Object& object = scenario_->objects[static_cast<std::size_t>(object_index)];
    std::vector<std::string> names;
    for (const Frame& frame : object.frames) {
      if (frame.name == element.Get(attribute)) return &frame;
      names.push_back(frame.name);
    }
    Report(element.LineOf(attribute),
           element.name + " '" + element.Get("name") + "': object '" + object.name + "' has no frame '" +
               element.Get(attribute) + "'",
           std::string(attribute) + " must name a <frame> of that object",
           core::SuggestName(element.Get(attribute), names));
    return nullptr;
  }

  void ReadSnap(const XmlElement& element) {
    const ElementReader read(element);
    Mechanism snap = Start(element, MechanismKind::kSnap);
    const Frame* parent_frame = FrameOf(element, "parent_frame", snap.parent);
    const Frame* child_frame = FrameOf(element, "child_frame", snap.child);
    if (parent_frame != nullptr) snap.X_PJ = parent_frame->X_OF;
    if (child_frame != nullptr) snap.X_CJ = child_frame->X_OF;
    read.Number("engage_force_N", &snap.engage_force_N);
    read.Number("release_force_N", &snap.release_force_N);
    read.Number("travel_m", &snap.travel_m);
    ReadProfile(element, &snap);
    read.Number("guide_length_m", &snap.guide_length_m);
    read.Number("lateral_tolerance_m", &snap.lateral_tolerance_m);
    read.Degrees("tilt_tolerance_deg", &snap.tilt_tolerance_rad);
    read.Number("stiffness_N_per_m", &snap.stiffness_N_per_m);
    read.Number("stiffness_Nm_per_rad", &snap.stiffness_Nm_per_rad);
    read.Boolean("engaged", &snap.is_initially_engaged);
    if (snap.is_initially_engaged && parent_frame != nullptr && child_frame != nullptr) CheckEngaged(element, snap);
    scenario_->mechanisms.push_back(std::move(snap));
  }

  // A snap's potential has two wells, the seat and the free position outside, with a barrier between them.
  void ReadProfile(const XmlElement& element, Mechanism* snap) {
    std::vector<double> numbers;
    if (element.Find("profile") == nullptr || !ParseNumbers(element.Get("profile"), &numbers)) return;
    const std::string title = "snap '" + snap->name + "': profile ";
    const int line = element.LineOf("profile");
    if (numbers.size() % 2 != 0 || numbers.size() < 6 || numbers.size() > 2 * kMaxProfilePoints) {
      Report(line, title + "has " + std::to_string(numbers.size()) + " numbers",
             "it is 3 to 16 points, each a distance from the seat in m and a force in N", "give z F for every point");
      return;
    }
    double largest_N = 0.0;
    for (std::size_t i = 0; i < numbers.size(); i += 2) {
      snap->profile.emplace_back(numbers[i], numbers[i + 1]);
      largest_N = std::max(largest_N, numbers[i + 1]);
      if (numbers[i] <= (i == 0 ? 0.0 : numbers[i - 2]) || numbers[i + 1] < 0.0) {
        Report(line, title + "is out of order at point " + std::to_string(i / 2 + 1),
               "distances must be positive and ascending, forces zero or above", "sort and correct the points");
        return;
      }
    }
    if (largest_N == 0.0) {
      Report(line, title + "has one well only", "without a force that resists insertion there is no barrier",
             "give the barrier's force between the first and the last point");
    } else if (snap->profile.back().y != 0.0) {
      Report(line, title + "has no second well: " + std::to_string(snap->profile.back().y) + " N at its outer end",
             "the part is free beyond the outer end, so the force must be zero there",
             "end it with a point of force 0");
    } else if (snap->profile.front().y != 0.0) {
      Report(line, title + "has no first well: " + std::to_string(snap->profile.front().y) + " N at its inner end",
             "the seat's spring begins there, so the force must be zero", "begin it with a point of force 0");
    }
    for (const char* attribute : {"engage_force_N", "travel_m"}) {
      if (element.Find(attribute) == nullptr) continue;
      Report(element.LineOf(attribute), "snap '" + snap->name + "': both " + attribute + " and profile",
             "the profile determines it", std::string("remove ") + attribute);
    }
    snap->engage_force_N = largest_N;
    snap->travel_m = snap->profile.back().x;
  }

  // An engaged snap that starts away from its seat would accelerate the child: X_JpJc must be the identity within the
  // snap's own tolerances.
  void CheckEngaged(const XmlElement& element, const Mechanism& snap) {
    const core::Pose X_JpJc = (PoseOf(snap.parent) * snap.X_PJ).inverse() * (PoseOf(snap.child) * snap.X_CJ);
    const double distance_m = glm::length(X_JpJc.translation);
    const double tilt_rad = glm::length(core::RotationVector(X_JpJc.rotation));
    if (distance_m <= snap.travel_m && tilt_rad <= snap.tilt_tolerance_rad) return;
    Report(element.LineOf("engaged"),
           "snap '" + snap.name + "': engaged, but its frames are " + std::to_string(distance_m * 1e3) + " mm and " +
               std::to_string(tilt_rad / kRadPerDeg) + " degrees apart",
           "an engaged snap starts in its seat: within travel_m and tilt_tolerance_deg",
           "place the child so that its frame lies on the parent's, or write engaged=\"false\"");
  }

  // Patches are points of the parent. J is the parent's mesh frame; fixed in the child, it starts at the same pose.
  void ReadHookAndLoop(const XmlElement& element) {
    const ElementReader read(element);
    Mechanism patches = Start(element, MechanismKind::kHookAndLoop);
    patches.X_CJ = PoseOf(patches.child).inverse() * PoseOf(patches.parent);
    read.Number("release_force_N", &patches.release_force_N);
    read.Number("stiffness_N_per_m", &patches.stiffness_N_per_m);
    std::vector<double> numbers;
    ParseNumbers(element.Get("patches_m"), &numbers);
    if (numbers.empty() || numbers.size() % 3 != 0) {
      Report(element.LineOf("patches_m"),
             "hook_and_loop '" + patches.name + "': patches_m has " + std::to_string(numbers.size()) + " numbers",
             "each patch is a point of three coordinates", "give x y z for every patch");
    }
    for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
      patches.patches_m.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
    }
    scenario_->mechanisms.push_back(std::move(patches));
  }

  const std::filesystem::path& file_;
  Scenario* scenario_;
  std::vector<Diagnostic>* diagnostics_;
};

}  // namespace

void ReadMechanisms(const XmlElement& root, const std::filesystem::path& file, Scenario* scenario,
                    std::vector<Diagnostic>* diagnostics) {
  MechanismReader reader(file, scenario, diagnostics);
  for (const XmlElement& element : root.children) reader.Read(element);
}

}  // namespace scene
