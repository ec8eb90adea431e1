#include "scene/read_scenario.hpp"

#include <glm/gtc/constants.hpp>

#include "core/names.hpp"
#include "scene/schema.hpp"

namespace scene {
namespace {

constexpr double kRadPerDeg = glm::pi<double>() / 180.0;

// Typed access to one element's attributes. A value that is absent or unreadable leaves the target alone: the rules of
// schema.hpp have reported it.
class Reader {
 public:
  explicit Reader(const XmlElement& element) : element_(element) {}

  void Number(const char* name, double* value) const { ParseNumber(element_.Get(name), value); }
  void Degrees(const char* name, double* value_rad) const {
    double value_deg = 0.0;
    if (ParseNumber(element_.Get(name), &value_deg)) *value_rad = value_deg * kRadPerDeg;
  }
  void Truth(const char* name, bool* value) const { ParseTruth(element_.Get(name), value); }
  [[nodiscard]] std::uint64_t Count(const char* name, std::uint64_t fallback) const {
    std::uint64_t value = fallback;
    ParseCount(element_.Get(name), &value);
    return value;
  }
  template <typename Vec>
  void Vector(const char* name, Vec* value) const {
    std::vector<double> numbers;
    if (ParseNumbers(element_.Get(name), &numbers) && numbers.size() == 3)
      *value = Vec(numbers[0], numbers[1], numbers[2]);
  }
  [[nodiscard]] core::Pose Pose() const {
    glm::dvec3 position_m(0.0);
    glm::dvec3 rpy_deg(0.0);
    Vector("position", &position_m);
    Vector("rpy_deg", &rpy_deg);
    return {core::QuaternionFromRollPitchYaw(rpy_deg * kRadPerDeg), position_m};
  }

 private:
  const XmlElement& element_;
};

class Builder {
 public:
  Builder(const std::filesystem::path& file, std::vector<Diagnostic>* diagnostics)
      : file_(file), diagnostics_(diagnostics) {
    scenario_.file = std::filesystem::absolute(file).lexically_normal();
    scenario_.folder = scenario_.file.parent_path();
  }

  Scenario Build(const XmlElement& root, std::vector<PairElement>* pairs) {
    scenario_.name = root.Get("name");
    scenario_.title = root.Get("title");
    for (const XmlElement& child : root.children) {
      if (child.name == "run") ReadRun(child);
      if (child.name == "procedure") scenario_.procedure = File(child, "file");
      if (child.name == "operator") scenario_.operator_script = File(child, "file");
      if (child.name == "coupling") ReadCoupling(child);
      if (child.name == "object") ReadObject(child);
      if (child.name == "device") ReadDevice(child);
      if (child.name == "pair") ReadPair(child, pairs);
      if (child.name == "parameter") ReadParameter(child);
      if (child.name == "camera") ReadCamera(child);
      if (child.name == "sun") Reader(child).Vector("direction", &scenario_.sun_direction_W);
    }
    ReadHands(root);
    // In file order, whatever their kind: the order is the id on the bus. After hands, whose poses they may need.
    for (const XmlElement& child : root.children) {
      if (child.name == "hinge") ReadHinge(child);
      if (child.name == "snap") ReadSnap(child);
      if (child.name == "hook_and_loop") ReadHookAndLoop(child);
    }
    return std::move(scenario_);
  }

 private:
  void Say(int line, std::string what, std::string why, std::string fix) {
    diagnostics_->push_back({{file_, line}, std::move(what), std::move(why), std::move(fix)});
  }

  // Absolute path of a file attribute; says so when it is not there.
  std::filesystem::path File(const XmlElement& element, const char* attribute) {
    const std::string value = element.Get(attribute);
    if (value.empty()) return {};
    const std::filesystem::path path = (scenario_.folder / value).lexically_normal();
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
      const bool is_mesh = std::string_view(attribute) == "mesh";
      Say(element.LineOf(attribute),
          std::string(is_mesh ? "mesh" : element.name + " file") + " '" + value + "' is missing",
          "there is no file " + path.string(),
          is_mesh ? "make the mesh (see the sources beside it) or correct the path"
                  : "write the file or correct the path");
    }
    return path;
  }

  void ReadRun(const XmlElement& element) {
    const Reader read(element);
    scenario_.method = element.Get("method", scenario_.method);
    const std::string input = element.Get("contact_input");
    if (input == "wrench") scenario_.contact_input = ContactInput::kWrench;
    if (input == "manifold") scenario_.contact_input = ContactInput::kManifold;
    scenario_.seed = read.Count("seed", scenario_.seed);
    read.Number("duration_limit_s", &scenario_.duration_limit_s);
    read.Number("stall_limit_s", &scenario_.stall_limit_s);
    read.Number("force_cap_N", &scenario_.force_cap_N);
  }

  void ReadCoupling(const XmlElement& element) {
    const Reader read(element);
    Coupling& coupling = scenario_.coupling;
    read.Number("stiffness_N_per_m", &coupling.stiffness_N_per_m);
    read.Number("stiffness_Nm_per_rad", &coupling.stiffness_Nm_per_rad);
    read.Number("eta", &coupling.eta);
    read.Number("sigma_m2", &coupling.sigma_m2);
    read.Number("rho", &coupling.rho);
    read.Number("alpha", &coupling.alpha);
    read.Number("grasp_stiffness_N_per_m", &coupling.grasp_stiffness_N_per_m);
    read.Number("grasp_damping_N_s_per_m", &coupling.grasp_damping_N_s_per_m);
    read.Number("grasp_stiffness_Nm_per_rad", &coupling.grasp_stiffness_Nm_per_rad);
    read.Number("grasp_damping_Nm_s_per_rad", &coupling.grasp_damping_Nm_s_per_rad);
    read.Number("jaw_stiffness_N_per_m", &coupling.jaw_stiffness_N_per_m);
  }

  void ReadObject(const XmlElement& element) {
    const Reader read(element);
    Object object;
    object.location = {file_, element.line};
    object.name = element.Get("name");
    object.group = element.Get("group", object.name);
    if (element.Get("owner") == "physics") object.owner = Owner::kPhysics;
    if (element.Get("owner") == "hand") object.owner = Owner::kHand;
    if (element.Get("part") == "palm") object.part = HandPart::kPalm;
    if (element.Get("part") == "jaw_left") object.part = HandPart::kJawLeft;
    if (element.Get("part") == "jaw_right") object.part = HandPart::kJawRight;
    object.X_WO = read.Pose();
    read.Number("mass_kg", &object.mass_kg);
    read.Number("density_kg_per_m3", &object.density_kg_per_m3);
    for (const XmlElement& child : element.children) {
      const Reader read_child(child);
      if (child.name == "visual") {
        object.visual_mesh = File(child, "mesh");
        object.material.is_given = child.Find("base_color") != nullptr;
        read_child.Vector("base_color", &object.material.base_color);
        double metallic = object.material.metallic;
        double roughness = object.material.roughness;
        read_child.Number("metallic", &metallic);
        read_child.Number("roughness", &roughness);
        object.material.metallic = static_cast<float>(metallic);
        object.material.roughness = static_cast<float>(roughness);
      } else if (child.name == "collision") {
        object.collision_mesh = File(child, "mesh");
        read_child.Number("voxel_size_m", &object.voxel_size_m);
        read_child.Number("sheet_thickness_m", &object.sheet_thickness_m);
        object.num_points =
            static_cast<std::uint32_t>(std::min<std::uint64_t>(read_child.Count("points", 0), UINT32_MAX));
        if (object.voxel_size_m <= 0.0 && object.num_points == 0 && child.Find("voxel_size_m") == nullptr) {
          Say(child.line, "object '" + object.name + "': <collision> without voxel_size_m and points",
              "it would build nothing", "give voxel_size_m for a voxelmap, points for a pointshell, or both");
        }
      } else if (child.name == "frame") {
        ReadFrame(child, &object);
      } else if (child.name == "sheet") {
        object.sheet = ReadSheet(child, object, file_, diagnostics_);
      } else if (child.name == "lamp") {
        object.is_lamp = true;
        read_child.Vector("color", &object.lamp_color);
      }
    }
    if ((object.voxel_size_m > 0.0 || object.num_points > 0) && object.collision_mesh.empty()) {
      object.collision_mesh = object.visual_mesh;
      if (object.visual_mesh.empty()) {
        Say(element.line, "object '" + object.name + "': <collision> has no mesh",
            "neither <collision> nor <visual> names one", "add mesh=\"...\" to <collision>");
      }
    }
    CheckOwner(element, object);
    scenario_.objects.push_back(std::move(object));
  }

  // Attributes that an owner asks for or rules out. A value that is wrong in itself counts as given: one message is
  // enough.
  void CheckOwner(const XmlElement& element, const Object& object) {
    const std::string title = "object '" + object.name + "': ";
    const bool has_mass = element.Find("mass_kg") != nullptr;
    const bool has_density = element.Find("density_kg_per_m3") != nullptr;
    if (has_mass && has_density) {
      Say(element.LineOf("density_kg_per_m3"), title + "both mass_kg and density_kg_per_m3",
          "mass follows from density and the mesh's volume, so one of them is too many", "remove one");
    } else if (object.owner == Owner::kPhysics && !has_mass && !has_density) {
      Say(element.line, title + "no mass", "an object that physics moves needs one above zero",
          "add mass_kg or density_kg_per_m3");
    }
    const bool is_hand = object.owner == Owner::kHand;
    for (const char* attribute : {"part", "role"}) {
      const bool is_given = element.Find(attribute) != nullptr;
      if (is_hand && !is_given) {
        Say(element.line, "object '" + object.name + "': " + attribute + " is missing",
            "an object with owner=\"hand\" is a part of one device's hand",
            "add " + std::string(attribute) + "=\"...\"");
      } else if (!is_hand && is_given) {
        Say(element.LineOf(attribute), "object '" + object.name + "': " + attribute + " on an object that is no hand",
            "only parts of a hand have it", "remove " + std::string(attribute) + " or write owner=\"hand\"");
      }
    }
    for (const char* attribute : {"position", "rpy_deg"}) {
      if (is_hand && element.Find(attribute) != nullptr) {
        Say(element.LineOf(attribute), "object '" + object.name + "': " + attribute + " on a part of a hand",
            "its pose follows the device", "remove it and set the start pose on <device>");
      }
    }
  }

  void ReadFrame(const XmlElement& element, Object* object) {
    Frame frame{element.Get("name"), Reader(element).Pose()};
    for (const Frame& other : object->frames) {
      if (other.name == frame.name) {
        Say(element.line, "object '" + object->name + "': a second frame '" + frame.name + "'",
            "names of frames are unique in an object", "rename one of them");
      }
    }
    object->frames.push_back(std::move(frame));
  }

  void ReadDevice(const XmlElement& element) {
    const Reader read(element);
    Device device;
    device.location = {file_, element.line};
    device.role = element.Get("role");
    device.type = element.Get("type", device.type);
    device.X_WD_start = read.Pose();
    read.Number("mass_kg", &device.mass_kg);
    read.Number("inertia_kg_m2", &device.inertia_kg_m2);
    read.Number("damping_N_s_per_m", &device.damping_N_s_per_m);
    read.Number("damping_Nm_s_per_rad", &device.damping_Nm_s_per_rad);
    read.Number("opening_max_m", &device.opening_max_m);
    read.Number("opening_start_m", &device.opening_start_m);
    read.Number("command_delay_s", &device.command_delay_s);
    read.Number("hand_stiffness_N_per_m", &device.hand_stiffness_N_per_m);
    read.Number("hand_damping_N_s_per_m", &device.hand_damping_N_s_per_m);
    read.Number("hand_stiffness_Nm_per_rad", &device.hand_stiffness_Nm_per_rad);
    read.Number("hand_damping_Nm_s_per_rad", &device.hand_damping_Nm_s_per_rad);
    read.Number("max_force_N", &device.max_force_N);
    read.Number("max_torque_Nm", &device.max_torque_Nm);
    read.Number("max_force_rate_N_per_s", &device.max_force_rate_N_per_s);
    scenario_.devices.push_back(std::move(device));
  }

  void ReadPair(const XmlElement& element, std::vector<PairElement>* pairs) const {
    const Reader read(element);
    PairElement pair;
    pair.a = element.Get("a");
    pair.b = element.Get("b");
    pair.figures.location = {file_, element.line};
    read.Number("stiffness_N_per_m", &pair.figures.stiffness_N_per_m);
    read.Number("damping_N_s_per_m", &pair.figures.damping_N_s_per_m);
    read.Number("friction", &pair.figures.friction);
    read.Number("look_ahead_m", &pair.figures.look_ahead_m);
    read.Truth("active", &pair.figures.is_active);
    read.Truth("collide", &pair.is_collide);
    if (element.Get("owner") == "physics") pair.figures.owner = PairOwner::kPhysics;
    pairs->push_back(std::move(pair));
  }

  void ReadParameter(const XmlElement& element) {
    Parameter parameter;
    parameter.name = element.Get("name");
    Reader(element).Number("value", &parameter.value);
    for (const Parameter& other : scenario_.parameters) {
      if (other.name == parameter.name) {
        Say(element.line, "a second parameter '" + parameter.name + "'", "names of parameters are unique",
            "remove one of them");
      }
    }
    scenario_.parameters.push_back(std::move(parameter));
  }

  void ReadCamera(const XmlElement& element) {
    const Reader read(element);
    Camera camera;
    camera.name = element.Get("name");
    read.Vector("eye_m", &camera.eye_m);
    read.Vector("target_m", &camera.target_m);
    read.Degrees("vertical_fov_deg", &camera.vertical_fov_rad);
    if (camera.vertical_fov_rad > 170.0 * kRadPerDeg) {
      Say(element.LineOf("vertical_fov_deg"), "camera '" + camera.name + "': vertical_fov_deg is above 170",
          "such a picture shows nothing of use", "write an angle in degrees, 30 to 60 is usual");
    }
    if (glm::distance(camera.eye_m, camera.target_m) < 1e-6) {
      Say(element.line, "camera '" + camera.name + "': eye and target coincide", "it has no direction to look in",
          "move eye_m or target_m");
    }
    for (const Camera& other : scenario_.cameras) {
      if (other.name == camera.name) {
        Say(element.line, "a second camera '" + camera.name + "'", "names of cameras are unique", "rename one of them");
      }
    }
    scenario_.cameras.push_back(std::move(camera));
  }

  // Parts find their device by role; their first pose follows from the device's.
  void ReadHands(const XmlElement& root) {
    std::vector<std::string> roles;
    for (const Device& device : scenario_.devices) roles.push_back(device.role);
    std::size_t index = 0;
    for (const XmlElement& element : root.children) {
      if (element.name != "object") continue;
      Object& object = scenario_.objects[index];
      const int object_index = static_cast<int>(index++);
      if (object.owner != Owner::kHand || element.Find("role") == nullptr) continue;
      object.role = scenario_.FindRole(element.Get("role"));
      if (object.role < 0) {
        Say(element.LineOf("role"),
            "object '" + object.name + "': no device has the role '" + element.Get("role") + "'",
            "a hand's parts belong to a <device>", core::SuggestName(element.Get("role"), roles));
        continue;
      }
      Device& device = scenario_.devices[static_cast<std::size_t>(object.role)];
      object.X_WO = PartPose(object.part, device.X_WD_start, device.opening_start_m);
      int* slot = nullptr;
      if (object.part == HandPart::kPalm) slot = &device.palm;
      if (object.part == HandPart::kJawLeft) slot = &device.jaw_left;
      if (object.part == HandPart::kJawRight) slot = &device.jaw_right;
      if (slot == nullptr) continue;
      if (*slot >= 0) {
        Say(element.line,
            "object '" + object.name + "': role '" + device.role + "' has this part already, '" +
                scenario_.objects[static_cast<std::size_t>(*slot)].name + "'",
            "a hand has one palm and one jaw on each side", "change its part or its role");
        continue;
      }
      *slot = object_index;
    }
  }

  // Index of the object that an attribute names; -1 and a message when there is none.
  int ObjectOf(const XmlElement& element, const char* attribute) {
    const std::string name = element.Get(attribute);
    const int index = scenario_.FindObject(name);
    if (index < 0 && !name.empty()) {
      std::vector<std::string> names;
      for (const Object& object : scenario_.objects) names.push_back(object.name);
      Say(element.LineOf(attribute), element.name + " '" + element.Get("name") + "': unknown object '" + name + "'",
          std::string(attribute) + " must name an <object> of this file", core::SuggestName(name, names));
    }
    return index;
  }

  core::Pose PoseOf(int object) const {
    return object < 0 ? core::Pose{} : scenario_.objects[static_cast<std::size_t>(object)].X_WO;
  }

  Mechanism Start(const XmlElement& element, MechanismKind kind) {
    Mechanism mechanism;
    mechanism.kind = kind;
    mechanism.location = {file_, element.line};
    mechanism.name = element.Get("name");
    mechanism.parent = ObjectOf(element, "parent");
    mechanism.child = ObjectOf(element, "child");
    Reader(element).Number("damping", &mechanism.damping);
    return mechanism;
  }

  // J is given in W with the child at angle 0: X_PJ = X_WP^-1 X_WJ and X_CJ = X_WC^-1 X_WJ. A toggle switch then starts
  // in its detent, so the child's first pose is turned there: X_WC = X_WJ Rz(detent) X_CJ^-1.
  void ReadHinge(const XmlElement& element) {
    const Reader read(element);
    Mechanism hinge = Start(element, MechanismKind::kHinge);
    const core::Pose X_WJ = read.Pose();
    hinge.X_PJ = PoseOf(hinge.parent).inverse() * X_WJ;
    hinge.X_CJ = PoseOf(hinge.child).inverse() * X_WJ;
    read.Degrees("lower_deg", &hinge.lower_rad);
    read.Degrees("upper_deg", &hinge.upper_rad);
    std::vector<double> detents_deg;
    ParseNumbers(element.Get("detents_deg"), &detents_deg);
    for (const double detent_deg : detents_deg) hinge.detents_rad.push_back(detent_deg * kRadPerDeg);
    read.Number("detent_torque_Nm", &hinge.detent_torque_Nm);
    const std::uint64_t initial_detent = read.Count("initial_detent", 0);
    hinge.initial_detent = static_cast<int>(std::min<std::uint64_t>(initial_detent, 1));
    read.Truth("stuck", &hinge.is_stuck);
    CheckHinge(element, hinge, initial_detent);
    if (hinge.detents_rad.size() == 2 && hinge.child >= 0) {
      const double angle_rad = hinge.detents_rad[static_cast<std::size_t>(hinge.initial_detent)];
      const core::Pose X_JpJc{glm::angleAxis(angle_rad, glm::dvec3(0, 0, 1)), glm::dvec3(0.0)};
      scenario_.objects[static_cast<std::size_t>(hinge.child)].X_WO = X_WJ * X_JpJc * hinge.X_CJ.inverse();
    }
    scenario_.mechanisms.push_back(std::move(hinge));
  }

  void CheckHinge(const XmlElement& element, const Mechanism& hinge, std::uint64_t initial_detent) {
    const std::string title = "hinge '" + hinge.name + "': ";
    if (hinge.lower_rad >= hinge.upper_rad) {
      Say(element.LineOf("lower_deg"), title + "lower_deg is not below upper_deg", "the hinge could not move",
          "swap the limits or widen them");
    }
    const std::vector<double>& detents = hinge.detents_rad;
    if (!detents.empty() && detents.size() != 2) {
      Say(element.LineOf("detents_deg"), title + std::to_string(detents.size()) + " detents",
          "a hinge has none or two, the two stable positions of a switch", "give two angles or remove detents_deg");
    } else if (detents.size() == 2 && detents[0] >= detents[1]) {
      Say(element.LineOf("detents_deg"), title + "detents are not ascending", "detent 0 is the lower angle",
          "write the lower angle first");
    } else if (detents.size() == 2 && (detents[0] < hinge.lower_rad || detents[1] > hinge.upper_rad)) {
      Say(element.LineOf("detents_deg"), title + "a detent is outside the limits", "the lever could never rest there",
          "widen lower_deg and upper_deg to hold both detents");
    }
    if (initial_detent > 1 || (initial_detent == 1 && detents.empty())) {
      Say(element.LineOf("initial_detent"), title + "initial_detent is " + std::to_string(initial_detent),
          "it is 0 or 1, the index in detents_deg", "write 0 or 1 and give two detents");
    }
  }

  // Index of a named frame of an object; nullptr and a message when there is none.
  const Frame* FrameOf(const XmlElement& element, const char* attribute, int object_index) {
    if (object_index < 0) return nullptr;
    const Object& object = scenario_.objects[static_cast<std::size_t>(object_index)];
    std::vector<std::string> names;
    for (const Frame& frame : object.frames) {
      if (frame.name == element.Get(attribute)) return &frame;
      names.push_back(frame.name);
    }
    Say(element.LineOf(attribute),
        element.name + " '" + element.Get("name") + "': object '" + object.name + "' has no frame '" +
            element.Get(attribute) + "'",
        std::string(attribute) + " must name a <frame> of that object",
        core::SuggestName(element.Get(attribute), names));
    return nullptr;
  }

  void ReadSnap(const XmlElement& element) {
    const Reader read(element);
    Mechanism snap = Start(element, MechanismKind::kSnap);
    const Frame* parent_frame = FrameOf(element, "parent_frame", snap.parent);
    const Frame* child_frame = FrameOf(element, "child_frame", snap.child);
    if (parent_frame != nullptr) snap.X_PJ = parent_frame->X_OF;
    if (child_frame != nullptr) snap.X_CJ = child_frame->X_OF;
    read.Number("engage_force_N", &snap.engage_force_N);
    read.Number("release_force_N", &snap.release_force_N);
    read.Number("travel_m", &snap.travel_m);
    read.Number("guide_length_m", &snap.guide_length_m);
    read.Number("lateral_tolerance_m", &snap.lateral_tolerance_m);
    read.Degrees("tilt_tolerance_deg", &snap.tilt_tolerance_rad);
    read.Number("stiffness_N_per_m", &snap.stiffness_N_per_m);
    read.Number("stiffness_Nm_per_rad", &snap.stiffness_Nm_per_rad);
    read.Truth("engaged", &snap.is_initially_engaged);
    if (snap.is_initially_engaged && parent_frame != nullptr && child_frame != nullptr) CheckEngaged(element, snap);
    scenario_.mechanisms.push_back(std::move(snap));
  }

  // An engaged snap that starts away from its seat would throw the child: X_JpJc must be the identity, nearly.
  void CheckEngaged(const XmlElement& element, const Mechanism& snap) {
    const core::Pose X_JpJc = (PoseOf(snap.parent) * snap.X_PJ).inverse() * (PoseOf(snap.child) * snap.X_CJ);
    const double distance_m = glm::length(X_JpJc.translation);
    const double tilt_rad = glm::length(core::RotationVector(X_JpJc.rotation));
    if (distance_m <= snap.travel_m && tilt_rad <= snap.tilt_tolerance_rad) return;
    Say(element.LineOf("engaged"),
        "snap '" + snap.name + "': engaged, but its frames are " + std::to_string(distance_m * 1e3) + " mm and " +
            std::to_string(tilt_rad / kRadPerDeg) + " degrees apart",
        "an engaged snap starts in its seat: within travel_m and tilt_tolerance_deg",
        "place the child so that its frame lies on the parent's, or write engaged=\"false\"");
  }

  // Patches are points of the parent; J is the parent's mesh frame, and the child's copy of it is where that lies at
  // start.
  void ReadHookAndLoop(const XmlElement& element) {
    const Reader read(element);
    Mechanism patches = Start(element, MechanismKind::kHookAndLoop);
    patches.X_CJ = PoseOf(patches.child).inverse() * PoseOf(patches.parent);
    read.Number("release_force_N", &patches.release_force_N);
    read.Number("stiffness_N_per_m", &patches.stiffness_N_per_m);
    std::vector<double> numbers;
    ParseNumbers(element.Get("patches_m"), &numbers);
    if (numbers.empty() || numbers.size() % 3 != 0) {
      Say(element.LineOf("patches_m"),
          "hook_and_loop '" + patches.name + "': patches_m has " + std::to_string(numbers.size()) + " numbers",
          "each patch is a point of three", "give x y z for every patch");
    }
    for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
      patches.patches_m.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
    }
    scenario_.mechanisms.push_back(std::move(patches));
  }

  const std::filesystem::path& file_;
  std::vector<Diagnostic>* diagnostics_;
  Scenario scenario_;
};

}  // namespace

Scenario ReadScenario(const XmlElement& root, const std::filesystem::path& file, std::vector<PairElement>* pairs,
                      std::vector<Diagnostic>* diagnostics) {
  return Builder(file, diagnostics).Build(root, pairs);
}

}  // namespace scene
