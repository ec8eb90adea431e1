#include "scene/read_scenario.hpp"

#include "core/names.hpp"
#include "scene/element_reader.hpp"
#include "scene/load_scenario.hpp"
#include "scene/schema.hpp"
#include "scene/udp_address.hpp"

namespace scene {
namespace {

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
      if (child.name == "user") ReadUser(child);
      if (child.name == "pair") ReadPair(child, pairs);
      if (child.name == "fingers") scenario_.hand_files.push_back(File(child, "hand"));
      if (child.name == "parameter") ReadParameter(child);
      if (child.name == "sun") ElementReader(child).Vector("direction", &scenario_.place.sun_W);
      if (child.name == "environment") ReadEnvironment(child);
    }
    for (const XmlElement& child : root.children) {
      if (child.name == "camera") ReadCamera(child);  // after the objects that they name
      if (child.name == "tactile") ReadTactile(child);
    }
    ReadHands(root);
    ReadScenery(root, file_, &scenario_, diagnostics_);
    ReadMechanisms(root, file_, &scenario_, diagnostics_);  // after hands, whose poses they may need
    return std::move(scenario_);
  }

 private:
  void Report(int line, std::string what, std::string why, std::string fix) {
    diagnostics_->push_back({{file_, line}, std::move(what), std::move(why), std::move(fix)});
  }

  // Absolute path of a file attribute; adds a diagnostic when the file does not exist.
  std::filesystem::path File(const XmlElement& element, const char* attribute) {
    const std::string value = element.Get(attribute);
    if (value.empty()) return {};
    const std::filesystem::path path = (scenario_.folder / value).lexically_normal();
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
      const bool is_mesh = std::string_view(attribute) == "mesh";
      Report(element.LineOf(attribute),
             std::string(is_mesh ? "mesh" : element.name + " file") + " '" + value + "' is missing",
             path.string() + " does not exist",
             is_mesh ? "make the mesh (see the sources beside it) or correct the path"
                     : "write the file or correct the path");
    }
    return path;
  }

  void ReadRun(const XmlElement& element) {
    const ElementReader read(element);
    scenario_.method = element.Get("method", scenario_.method);
    read.Number("accuracy", &scenario_.accuracy);
    read.Number("budget_us", &scenario_.budget_us);
    const std::string input = element.Get("contact_input");
    if (input == "wrench") scenario_.contact_input = ContactInput::kWrench;
    if (input == "manifold") scenario_.contact_input = ContactInput::kManifold;
    scenario_.seed = read.Count("seed", scenario_.seed);
    read.Number("duration_limit_s", &scenario_.duration_limit_s);
    read.Number("stall_limit_s", &scenario_.stall_limit_s);
    read.Number("force_cap_N", &scenario_.force_cap_N);
    read.Vector("gravity_m_per_s2", &scenario_.gravity_m_per_s2);
  }

  void ReadEnvironment(const XmlElement& element) {
    const ElementReader read(element);
    space::Place& place = scenario_.place;
    if (const auto epoch = space::ParseInstant(element.Get("epoch"))) place.epoch = *epoch;
    double altitude_km = 0.0;
    if (ParseNumber(element.Get("altitude_km"), &altitude_km)) place.orbit.altitude_m = 1e3 * altitude_km;
    read.Degrees("inclination_deg", &place.orbit.inclination_rad);
    read.Degrees("node_deg", &place.orbit.node_rad);
    read.Degrees("argument_deg", &place.orbit.argument_rad);
    read.Vector("zenith", &place.zenith_W);
  }

  void ReadCoupling(const XmlElement& element) {
    const ElementReader read(element);
    Coupling& coupling = scenario_.coupling;
    coupling.type = element.Get("type", coupling.type);
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
    coupling.is_grip_by_friction = element.Get("grip") == "friction";
    read.Boolean("reevaluate", &coupling.is_reevaluated);
    read.Boolean("field", &coupling.has_field);
  }

  void ReadObject(const XmlElement& element) {
    const ElementReader read(element);
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
    ReadFingerLink(element, &object);
    read.Number("mass_kg", &object.mass_kg);
    read.Number("density_kg_per_m3", &object.density_kg_per_m3);
    ReadInertia(element, &object);
    read.Vector("velocity_m_per_s", &object.V_WO.linear_m_per_s);
    read.Vector("spin_rad_per_s", &object.V_WO.angular_rad_per_s);
    for (const XmlElement& child : element.children) {
      const ElementReader read_child(child);
      if (child.name == "visual") {
        object.visual_mesh = File(child, "mesh");
        object.material = ReadMaterial(child);
      } else if (child.name == "collision") {
        object.collision_mesh = File(child, "mesh");
        read_child.Number("voxel_size_m", &object.voxel_size_m);
        read_child.Number("sheet_thickness_m", &object.sheet_thickness_m);
        object.num_points =
            static_cast<std::uint32_t>(std::min<std::uint64_t>(read_child.Count("points", 0), UINT32_MAX));
        const bool has_voxel_size = child.Find("voxel_size_m") != nullptr;
        object.is_resolution_chosen = !has_voxel_size && child.Find("points") == nullptr;
        if (!object.is_resolution_chosen && !has_voxel_size && object.num_points == 0) {
          Report(child.line, "object '" + object.name + "': <collision> with points=\"0\" and no voxel_size_m",
                 "it describes neither a field nor points", "remove points, so that both are chosen, or give more");
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
    if ((object.voxel_size_m > 0.0 || object.num_points > 0 || object.is_resolution_chosen) &&
        object.collision_mesh.empty()) {
      object.collision_mesh = object.visual_mesh;
      if (object.visual_mesh.empty()) {
        Report(element.line, "object '" + object.name + "': <collision> has no mesh",
               "neither <collision> nor <visual> names one", "add mesh=\"...\" to <collision>");
      }
    }
    CheckOwner(element, object);
    scenario_.objects.push_back(std::move(object));
  }

  // Of what ExpandFingers has made.
  void ReadFingerLink(const XmlElement& element, Object* object) const {
    if (element.Find("finger_role") == nullptr) return;
    const ElementReader read(element);
    FingerLink link;
    link.finger = static_cast<int>(read.Count("finger", 0));
    read.Number("friction", &link.friction);
    read.Number("stiffness_N_per_m", &link.stiffness_N_per_m);
    read.Number("damping_N_s_per_m", &link.damping_N_s_per_m);
    object->finger_link = link;  // its role follows when the devices are known
  }

  // A given inertia tensor I [kg m^2] about the centre of mass replaces that of the mesh. It must be that of a real
  // mass distribution: the second moments of mass S = tr(I) / 2 E - I must be positive semidefinite, which is the
  // triangle inequality of the principal moments; checked by the principal minors, to 1e-9 for rounding of the file's
  // numbers.
  void ReadInertia(const XmlElement& element, Object* object) {
    std::vector<double> v;
    if (element.Find("inertia_kg_m2") == nullptr || !ParseNumbers(element.Get("inertia_kg_m2"), &v)) return;
    const std::string title = "object '" + object->name + "': ";
    const int line = element.LineOf("inertia_kg_m2");
    if (v.size() != 6) {
      Report(line, title + "inertia_kg_m2 has " + std::to_string(v.size()) + " numbers",
             "a symmetric tensor about the centre of mass has six: xx yy zz xy xz yz", "give all six");
      return;
    }
    if (object->mass_kg <= 0.0) {
      Report(line, title + "inertia_kg_m2 without mass_kg", "an inertia belongs to a mass", "add mass_kg");
    }
    Inertia inertia;
    inertia.I_Cm_O_kg_m2 = glm::dmat3(v[0], v[3], v[4], v[3], v[1], v[5], v[4], v[5], v[2]);
    ElementReader(element).Vector("center_of_mass_m", &inertia.p_OCm_m);
    const glm::dmat3 S = glm::dmat3(0.5 * (v[0] + v[1] + v[2])) - inertia.I_Cm_O_kg_m2;
    const double scale = v[0] + v[1] + v[2];
    const double minor = S[0][0] * S[1][1] - S[0][1] * S[0][1];
    if (scale <= 0.0 || S[0][0] < 0.0 || S[1][1] < 0.0 || S[2][2] < 0.0 || minor < -1e-9 * scale * scale ||
        glm::determinant(S) < -1e-9 * scale * scale * scale || glm::determinant(inertia.I_Cm_O_kg_m2) <= 0.0) {
      Report(line, title + "inertia_kg_m2 is not that of a real body",
             "each of its principal moments is above zero and at most the sum of the other two",
             "correct the numbers (xx yy zz xy xz yz), or omit inertia_kg_m2 to compute it from the mesh");
    }
    object->inertia = inertia;
  }

  // Attributes that an owner requires or excludes. A malformed value counts as given, as it has been reported already.
  void CheckOwner(const XmlElement& element, const Object& object) {
    const std::string title = "object '" + object.name + "': ";
    const bool has_mass = element.Find("mass_kg") != nullptr;
    const bool has_density = element.Find("density_kg_per_m3") != nullptr;
    if (has_mass && has_density) {
      Report(element.LineOf("density_kg_per_m3"), title + "both mass_kg and density_kg_per_m3",
             "density and the mesh's volume determine the mass", "remove one of them");
    } else if (object.owner == Owner::kPhysics && !has_mass && !has_density) {
      Report(element.line, title + "no mass", "an object that physics moves needs one above zero",
             "add mass_kg or density_kg_per_m3");
    }
    for (const char* attribute : {"velocity_m_per_s", "spin_rad_per_s"}) {
      if (object.owner != Owner::kPhysics && element.Find(attribute) != nullptr) {
        Report(element.LineOf(attribute), title + attribute + " on an object that physics does not move",
               "it is at rest or follows a device", "remove it or write owner=\"physics\"");
      }
    }
    const bool is_hand = object.owner == Owner::kHand;
    for (const char* attribute : {"part", "role"}) {
      const bool is_given = element.Find(attribute) != nullptr;
      if (is_hand && !is_given) {
        Report(element.line, "object '" + object.name + "': " + attribute + " is missing",
               "an object with owner=\"hand\" is a part of one device's hand",
               "add " + std::string(attribute) + "=\"...\"");
      } else if (!is_hand && is_given) {
        Report(element.LineOf(attribute),
               "object '" + object.name + "': " + attribute + " on an object that is not part of a hand",
               "only parts of a hand have it", "remove " + std::string(attribute) + " or write owner=\"hand\"");
      }
    }
    for (const char* attribute : {"position", "rpy_deg"}) {
      if (is_hand && element.Find(attribute) != nullptr) {
        Report(element.LineOf(attribute), "object '" + object.name + "': " + attribute + " on a part of a hand",
               "its pose follows the device", "remove it and set the start pose on <device>");
      }
    }
  }

  void ReadFrame(const XmlElement& element, Object* object) {
    Frame frame{element.Get("name"), ElementReader(element).Pose()};
    for (const Frame& other : object->frames) {
      if (other.name == frame.name) {
        Report(element.line, "object '" + object->name + "': a second frame '" + frame.name + "'",
               "names of frames are unique in an object", "rename one of them");
      }
    }
    object->frames.push_back(std::move(frame));
  }

  // What a kind of head has no use for is a mistake: it would be passed over in silence.
  void CheckHead(const XmlElement& element, const User& user) {
    const std::string title = "user '" + user.name + "'";
    if (user.head == "dtrack") {
      if (user.address.empty()) {
        Report(element.line, title + " has no address", "a head by DTrack is received at a UDP port",
               "write address=\"5000\", the port that DTrack sends to");
      } else if (!ParseUdpAddress(user.address)) {
        Report(element.LineOf("address"), title + ": address is '" + user.address + "'",
               "a head by DTrack is received at a UDP port",
               "write the port that DTrack sends to, as 5000, or a multicast group and a port, as 239.0.1.1:5000");
      }
      return;
    }
    for (const char* attribute : {"address", "body", "position", "rpy_deg", "eyes_m", "eyes_rpy_deg"}) {
      if (element.Find(attribute) == nullptr) continue;
      Report(element.LineOf(attribute), title + ": " + attribute + " means nothing for head " + user.head,
             "only a head by DTrack is received, and stands in a tracker's room",
             "remove it, or write head=\"dtrack\"");
    }
  }

  void ReadUser(const XmlElement& element) {
    User user;
    user.location = {file_, element.line};
    user.name = element.Get("name");
    const ElementReader read(element);
    user.head = element.Get("head", user.head);
    user.address = element.Get("address");
    user.body = static_cast<int>(read.Count("body", 0));
    user.X_RT = read.Pose();
    glm::dvec3 eyes_rpy_deg(0.0);
    read.Vector("eyes_m", &user.X_BH.translation);
    read.Vector("eyes_rpy_deg", &eyes_rpy_deg);
    user.X_BH.rotation = core::QuaternionFromRollPitchYaw(glm::radians(eyes_rpy_deg));
    CheckHead(element, user);
    for (const User& other : scenario_.users) {
      if (other.name == user.name) {
        Report(element.line, "a second user '" + user.name + "'", "each user's head has a topic of its own",
               "rename or remove one of them");
      }
    }
    scenario_.users.push_back(std::move(user));
  }

  void ReadTactile(const XmlElement& element) {
    Tactile tactile;
    tactile.location = {file_, element.line};
    tactile.name = element.Get("name");
    tactile.type = element.Get("type", tactile.type);
    tactile.device_file = File(element, "device");
    const ElementReader read(element);
    tactile.X_OB = read.Pose();
    read.Number("full_depth_m", &tactile.full_depth_m);
    read.Number("full_force_N", &tactile.full_force_N);
    tactile.body = scenario_.FindObject(element.Get("body"));
    if (tactile.body < 0) {
      std::vector<std::string> names;
      for (const Object& object : scenario_.objects) names.push_back(object.name);
      Report(element.LineOf("body"),
             "tactile '" + tactile.name + "': no object is called '" + element.Get("body") + "'",
             "what this object touches is what is felt", core::SuggestName(element.Get("body"), names));
    }
    scenario_.tactiles.push_back(std::move(tactile));
  }

  void ReadDevice(const XmlElement& element) {
    const ElementReader read(element);
    Device device;
    device.location = {file_, element.line};
    device.role = element.Get("role");
    device.type = element.Get("type", device.type);
    device.address = element.Get("address");
    for (const XmlElement& child : element.children) {
      device.options.emplace_back(child.Get("name"), child.Get("value"));
    }
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
    const ElementReader read(element);
    PairElement pair;
    pair.a = element.Get("a");
    pair.b = element.Get("b");
    pair.figures.location = {file_, element.line};
    read.Number("stiffness_N_per_m", &pair.figures.stiffness_N_per_m);
    read.Number("damping_N_s_per_m", &pair.figures.damping_N_s_per_m);
    read.Number("friction", &pair.figures.friction);
    read.Number("look_ahead_m", &pair.figures.look_ahead_m);
    for (const auto& [name, to] : {std::pair{"accuracy", &pair.accuracy}, {"budget_us", &pair.budget_us}}) {
      double number = 0.0;
      if (ParseNumber(element.Get(name), &number)) *to = number;
    }
    read.Boolean("active", &pair.figures.is_active);
    read.Boolean("collide", &pair.is_collide);
    if (element.Get("owner") == "physics") pair.figures.owner = PairOwner::kPhysics;
    pairs->push_back(std::move(pair));
  }

  void ReadParameter(const XmlElement& element) {
    Parameter parameter;
    parameter.name = element.Get("name");
    ElementReader(element).Number("value", &parameter.value);
    for (const Parameter& other : scenario_.parameters) {
      if (other.name == parameter.name) {
        Report(element.line, "a second parameter '" + parameter.name + "'", "names of parameters are unique",
               "remove one of them");
      }
    }
    scenario_.parameters.push_back(std::move(parameter));
  }

  // The object that a camera is mounted on or follows.
  void ReadCarrier(const XmlElement& element, Camera* camera) {
    camera->is_mounted = element.Find("mounted_on") != nullptr;
    if (camera->is_mounted && element.Find("follows") != nullptr) {
      Report(element.LineOf("follows"), "camera '" + camera->name + "' is mounted and follows",
             "a mounted camera turns with its object, one that follows does not", "remove mounted_on or follows");
      return;
    }
    const char* const attribute = camera->is_mounted ? "mounted_on" : "follows";
    const std::string object = element.Get(attribute);
    if (object.empty()) return;
    camera->object = scenario_.FindObject(object);
    if (camera->object >= 0) return;
    std::vector<std::string> names;
    for (const Object& known : scenario_.objects) names.push_back(known.name);
    Report(element.LineOf(attribute), "camera '" + camera->name + "': no object is called '" + object + "'",
           "a camera is carried by an object of this scenario", core::SuggestName(object, names));
  }

  void ReadCamera(const XmlElement& element) {
    const ElementReader read(element);
    Camera camera;
    camera.name = element.Get("name");
    read.Vector("eye_m", &camera.eye_m);
    read.Vector("target_m", &camera.target_m);
    read.Degrees("vertical_fov_deg", &camera.vertical_fov_rad);
    if (camera.vertical_fov_rad > 170.0 * kRadPerDeg) {
      Report(element.LineOf("vertical_fov_deg"), "camera '" + camera.name + "': vertical_fov_deg is above 170",
             "such a perspective is too distorted to be useful", "write an angle in degrees, 30 to 60 is usual");
    }
    if (glm::distance(camera.eye_m, camera.target_m) < 1e-6) {
      Report(element.line, "camera '" + camera.name + "': eye and target coincide", "the view direction is undefined",
             "move eye_m or target_m");
    }
    for (const Camera& other : scenario_.cameras) {
      if (other.name == camera.name) {
        Report(element.line, "a second camera '" + camera.name + "'", "names of cameras are unique",
               "rename one of them");
      }
    }
    ReadCarrier(element, &camera);
    scenario_.cameras.push_back(std::move(camera));
  }

  // Assigns hand parts to devices by role, and computes their initial poses from the device's.
  void ReadHands(const XmlElement& root) {
    std::vector<std::string> roles;
    for (const Device& device : scenario_.devices) roles.push_back(device.role);
    std::size_t index = 0;
    for (const XmlElement& element : root.children) {
      if (element.name != "object") continue;
      Object& object = scenario_.objects[index];
      const int object_index = static_cast<int>(index++);
      if (object.finger_link) object.finger_link->role = scenario_.FindRole(element.Get("finger_role"));
      if (object.owner != Owner::kHand || element.Find("role") == nullptr) continue;
      object.role = scenario_.FindRole(element.Get("role"));
      if (object.role < 0) {
        Report(element.LineOf("role"),
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
        Report(element.line,
               "object '" + object.name + "': role '" + device.role + "' has this part already, '" +
                   scenario_.objects[static_cast<std::size_t>(*slot)].name + "'",
               "a hand has one palm and one jaw on each side", "change its part or its role");
        continue;
      }
      *slot = object_index;
    }
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
