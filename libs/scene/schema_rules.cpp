#include "scene/schema.hpp"

namespace scene {
namespace {

constexpr ValueKind kPlainNumber = ValueKind::kNumber;
constexpr ValueKind kAtLeastZero = ValueKind::kNonNegative;
constexpr ValueKind kAboveZero = ValueKind::kPositive;

AttributeRule Optional(const char* name, ValueKind kind) {
  return {name, kind, false, {}};
}
AttributeRule Required(const char* name, ValueKind kind) {
  return {name, kind, true, {}};
}

ElementRule RunRule() {
  return {
      "run",
      "settings of the run; accuracy: wanted error of contact forces over the integral of depth (method fast), within "
      "budget_us a pair and cycle",
      {{"method", ValueKind::kChoice, false, {"paper", "fast"}},
       Optional("accuracy", ValueKind::kShare),
       Optional("budget_us", kAboveZero),
       {"contact_input", ValueKind::kChoice, false, {"planes", "manifold", "wrench"}},
       Optional("seed", ValueKind::kCount),
       Optional("duration_limit_s", kAboveZero),
       Optional("stall_limit_s", kAboveZero),
       Optional("force_cap_N", kAboveZero),
       Optional("gravity_m_per_s2", ValueKind::kVector)},
      {}};
}

ElementRule CouplingRule() {
  return {"coupling",
          "virtual coupling [VR-OOS, Eq. 2-6] and grasp springs",
          {{"type", ValueKind::kChoice, false, {"paper", "god_object"}},
           Optional("stiffness_N_per_m", kAboveZero),
           Optional("stiffness_Nm_per_rad", kAboveZero),
           Optional("eta", kAtLeastZero),
           Optional("sigma_m2", kAboveZero),
           Optional("rho", kAtLeastZero),
           Optional("alpha", kAboveZero),
           Optional("grasp_stiffness_N_per_m", kAtLeastZero),
           Optional("grasp_damping_N_s_per_m", kAtLeastZero),
           Optional("grasp_stiffness_Nm_per_rad", kAtLeastZero),
           Optional("grasp_damping_Nm_s_per_rad", kAtLeastZero),
           Optional("jaw_stiffness_N_per_m", kAboveZero),
           {"grip", ValueKind::kChoice, false, {"spring", "friction"}},
           Optional("reevaluate", ValueKind::kBoolean),
           Optional("field", ValueKind::kBoolean)},
          {}};
}

ElementRule ObjectRule() {
  return {"object",
          "an object of the scene; pose of its mesh frame in W",
          {Required("name", ValueKind::kName),
           {"owner", ValueKind::kChoice, true, {"fixed", "physics", "hand"}},
           {"part", ValueKind::kChoice, false, {"palm", "jaw_left", "jaw_right"}},
           Optional("role", ValueKind::kName),
           Optional("group", ValueKind::kName),
           Optional("position", ValueKind::kVector),
           Optional("rpy_deg", ValueKind::kVector),
           Optional("mass_kg", kAboveZero),
           Optional("density_kg_per_m3", kAboveZero),
           Optional("inertia_kg_m2", ValueKind::kNumbers),
           Optional("center_of_mass_m", ValueKind::kVector),
           Optional("velocity_m_per_s", ValueKind::kVector),
           Optional("spin_rad_per_s", ValueKind::kVector)},
          {{"visual", 0, 1}, {"collision", 0, 1}, {"frame", 0, 0}, {"lamp", 0, 1}, {"sheet", 0, 1}}};
}

ElementRule SheetRule() {
  return {"sheet",
          "a deformable sheet sewn to the object; pose of its middle in the object's mesh frame",
          {Optional("position", ValueKind::kVector), Optional("rpy_deg", ValueKind::kVector),
           Required("size_m", ValueKind::kNumbers), Required("cells", ValueKind::kNumbers),
           Required("seam_size_m", ValueKind::kNumbers), Optional("density_kg_per_m2", kAboveZero),
           Optional("stretch_stiffness_N_per_m", kAboveZero), Optional("bending_stiffness_Nm", kAtLeastZero),
           Optional("thickness_m", kAtLeastZero), Optional("friction", kAtLeastZero),
           Optional("damping_per_s", kAtLeastZero), Optional("seam_stiffness_N_per_m", kAboveZero),
           Optional("seam_damping_N_s_per_m", kAtLeastZero), Optional("grip_stiffness_N_per_m", kAboveZero),
           Optional("grip_damping_N_s_per_m", kAtLeastZero), Optional("base_color", ValueKind::kColor),
           Optional("metallic", kAtLeastZero), Optional("roughness", kAtLeastZero),
           Optional("active", ValueKind::kBoolean)},
          {}};
}

ElementRule DeviceRule() {
  return {"device",
          "a hand device and its role",
          {Required("role", ValueKind::kName),
           {"type", ValueKind::kChoice, false, {std::begin(kDeviceTypes), std::end(kDeviceTypes)}},
           Optional("address", ValueKind::kText),
           Optional("position", ValueKind::kVector),
           Optional("rpy_deg", ValueKind::kVector),
           Optional("mass_kg", kAboveZero),
           Optional("inertia_kg_m2", kAboveZero),
           Optional("damping_N_s_per_m", kAtLeastZero),
           Optional("damping_Nm_s_per_rad", kAtLeastZero),
           Optional("opening_max_m", kAtLeastZero),
           Optional("opening_start_m", kAtLeastZero),
           Optional("command_delay_s", kAtLeastZero),
           Optional("hand_stiffness_N_per_m", kAboveZero),
           Optional("hand_damping_N_s_per_m", kAtLeastZero),
           Optional("hand_stiffness_Nm_per_rad", kAboveZero),
           Optional("hand_damping_Nm_s_per_rad", kAtLeastZero),
           Optional("max_force_N", kAboveZero),
           Optional("max_torque_Nm", kAboveZero),
           Optional("max_force_rate_N_per_s", kAboveZero)},
          {{"option", 0, 0}}};
}

ElementRule OptionRule() {
  return {"option",
          "what a device's plug-in shall know",
          {Required("name", ValueKind::kName), Required("value", ValueKind::kText)},
          {}};
}

ElementRule HingeRule() {
  return {
      "hinge",
      "rotation about z of J; two detents make it a toggle switch",
      {Required("name", ValueKind::kName), Optional("parent", ValueKind::kText), Required("child", ValueKind::kName),
       Required("position", ValueKind::kVector), Optional("rpy_deg", ValueKind::kVector),
       Optional("lower_deg", kPlainNumber), Optional("upper_deg", kPlainNumber),
       Optional("detents_deg", ValueKind::kNumbers), Optional("detent_torque_Nm", kAtLeastZero),
       Optional("initial_detent", ValueKind::kCount), Optional("start_deg", kPlainNumber),
       Optional("damping", kAtLeastZero), Optional("motor_deg_per_s", kPlainNumber),
       Optional("motor_torque_Nm", kAtLeastZero), Optional("locked", ValueKind::kBoolean)},
      {}};
}

ElementRule ArmRule() {
  return {"arm",
          "a chain of links joined by hinges; pose of its mount in W",
          {Required("name", ValueKind::kName), Required("links", ValueKind::kFile), Optional("base", ValueKind::kText),
           Optional("position", ValueKind::kVector), Optional("rpy_deg", ValueKind::kVector),
           Optional("start_deg", ValueKind::kNumbers)},
          {}};
}

ElementRule LinkRule() {
  return {"link",
          "a link turns about z of its frame, whose pose is given in the previous link's frame",
          {Optional("position", ValueKind::kVector), Optional("rpy_deg", ValueKind::kVector),
           Required("mass_kg", kAboveZero), Optional("inertia_kg_m2", ValueKind::kNumbers),
           Optional("center_of_mass_m", ValueKind::kVector), Optional("lower_deg", kPlainNumber),
           Optional("upper_deg", kPlainNumber), Optional("damping", kAtLeastZero),
           Optional("motor_deg_per_s", kPlainNumber), Optional("motor_torque_Nm", kAtLeastZero),
           Optional("locked", ValueKind::kBoolean)},
          {{"visual", 0, 1}, {"collision", 0, 1}, {"frame", 0, 0}}};
}

ElementRule FingersRule() {
  return {"fingers",
          "the fingers of a device's hand, on its palm: links that physics moves by servos to the device's angles",
          {Required("role", ValueKind::kName),
           Required("hand", ValueKind::kFile),
           {"side", ValueKind::kChoice, true, {"right", "left"}}},
          {}};
}

ElementRule HandRule() {
  return {"hand",
          "five fingers of a right hand, thumb first; a file of its own. How their pads touch",
          {Required("friction", kAtLeastZero), Required("stiffness_N_per_m", kAboveZero),
           Required("damping_N_s_per_m", kAtLeastZero)},
          {{"finger", 5, 5}}};
}

ElementRule FingerRule() {
  return {"finger",
          "a finger of three links, from the palm outwards",
          {Required("name", ValueKind::kName)},
          {{"joint", 3, 3}}};
}

ElementRule JointRule() {
  return {"joint",
          "a link of a finger, which turns about z of its frame; pose in the link before, at first in the palm's frame",
          {Optional("position", ValueKind::kVector), Optional("rpy_deg", ValueKind::kVector),
           Required("mass_kg", kAboveZero), Optional("inertia_kg_m2", ValueKind::kNumbers),
           Optional("center_of_mass_m", ValueKind::kVector), Required("lower_deg", kPlainNumber),
           Required("upper_deg", kPlainNumber), Optional("start_deg", kPlainNumber), Required("torque_Nm", kAboveZero),
           Required("servo_Nm_per_rad", kAboveZero), Required("servo_Nm_s_per_rad", kAtLeastZero)},
          {{"visual", 0, 1}, {"collision", 0, 1}}};
}

ElementRule SliderRule() {
  return {
      "slider",
      "motion along z of J",
      {Required("name", ValueKind::kName), Optional("parent", ValueKind::kText), Required("child", ValueKind::kName),
       Required("position", ValueKind::kVector), Optional("rpy_deg", ValueKind::kVector),
       Optional("lower_m", kPlainNumber), Optional("upper_m", kPlainNumber), Optional("damping", kAtLeastZero),
       Optional("motor_m_per_s", kPlainNumber), Optional("motor_force_N", kAtLeastZero),
       Optional("locked", ValueKind::kBoolean)},
      {}};
}

ElementRule SnapRule() {
  return {"snap",
          "a snap that pulls the child's frame into the parent's; it engages and releases",
          {Required("name", ValueKind::kName), Required("parent", ValueKind::kName),
           Required("parent_frame", ValueKind::kName), Required("child", ValueKind::kName),
           Required("child_frame", ValueKind::kName), Optional("engage_force_N", kAtLeastZero),
           Optional("release_force_N", kAtLeastZero), Optional("travel_m", kAboveZero),
           Optional("profile", ValueKind::kNumbers), Optional("guide_length_m", kAtLeastZero),
           Optional("lateral_tolerance_m", kAboveZero), Optional("tilt_tolerance_deg", kAboveZero),
           Optional("stiffness_N_per_m", kAtLeastZero), Optional("stiffness_Nm_per_rad", kAtLeastZero),
           Optional("damping", kAtLeastZero), Optional("engaged", ValueKind::kBoolean)},
          {}};
}

ElementRule HookAndLoopRule() {
  return {
      "hook_and_loop",
      "patches in the parent's mesh frame, each a spring that breaks",
      {Required("name", ValueKind::kName), Optional("parent", ValueKind::kText), Required("child", ValueKind::kName),
       Required("patches_m", ValueKind::kNumbers), Required("release_force_N", kAboveZero),
       Required("stiffness_N_per_m", kAboveZero), Optional("damping", kAtLeastZero)},
      {}};
}

ElementRule TactileRule() {
  return {"tactile",
          "a device that lets the skin feel what a body touches; pose of its frame on the body, z along the limb, x "
          "towards "
          "its first channel; full intensity at full_force_N when it is given, else at full_depth_m",
          {Required("name", ValueKind::kName),
           {"type", ValueKind::kChoice, false, {"simulated", "usb"}},
           Required("device", ValueKind::kFile),
           Required("body", ValueKind::kName),
           Optional("position", ValueKind::kVector),
           Optional("rpy_deg", ValueKind::kVector),
           Optional("full_depth_m", kAboveZero),
           Optional("full_force_N", kAboveZero)},
          {}};
}

std::vector<ElementRule> MakeRules() {
  return {
      {"scenario",
       "a scene, its devices and its procedure; SI units, degrees in attributes that end in _deg",
       {Required("name", ValueKind::kName), Optional("title", ValueKind::kText)},
       {{"run", 0, 1},       {"procedure", 1, 1}, {"operator", 0, 1},  {"coupling", 0, 1}, {"object", 1, 0},
        {"device", 0, 0},    {"user", 0, 0},      {"tactile", 0, 0},   {"pair", 0, 0},     {"hinge", 0, 0},
        {"slider", 0, 0},    {"arm", 0, 0},       {"fingers", 0, 0},   {"snap", 0, 0},     {"hook_and_loop", 0, 0},
        {"parameter", 0, 0}, {"scenery", 0, 0},   {"shown_arm", 0, 0}, {"camera", 0, 0},   {"environment", 0, 1},
        {"sun", 0, 1}}},
      RunRule(),
      {"procedure", "the SCXML file of the procedure", {Required("file", ValueKind::kFile)}, {}},
      {"operator", "the simulated operator's script", {Required("file", ValueKind::kFile)}, {}},
      CouplingRule(),
      ObjectRule(),
      {"visual",
       "the mesh that is drawn; variant: which of the looks that a glTF file has (KHR_materials_variants)",
       {Required("mesh", ValueKind::kFile), Optional("base_color", ValueKind::kColor),
        Optional("metallic", kAtLeastZero), Optional("roughness", kAtLeastZero), Optional("variant", ValueKind::kText)},
       {}},
      {"collision",
       "what is touched: the visual mesh unless mesh names another; voxel_size_m gives it a field, points a sampled "
       "surface; with neither both are chosen, from the accuracy of its pairs and the meshes' walls and gaps; an open "
       "mesh is a sheet of sheet_thickness_m",
       {Optional("mesh", ValueKind::kFile), Optional("voxel_size_m", kAboveZero), Optional("points", ValueKind::kCount),
        Optional("sheet_thickness_m", kAboveZero)},
       {},
       {{"accuracy_m",
         "write accuracy=\"0.1\" in <run> or <pair>, the error of the force, and let voxels be chosen; or name them by "
         "voxel_size_m"}}},
      {"frame",
       "a named frame fixed in the object's mesh frame",
       {Required("name", ValueKind::kName), Optional("position", ValueKind::kVector),
        Optional("rpy_deg", ValueKind::kVector)},
       {}},
      {"lamp", "the object is a lamp whose colour logic_node sets", {Optional("color", ValueKind::kColor)}, {}},
      SheetRule(),
      DeviceRule(),
      OptionRule(),
      {"pair",
       "changes the parameters of a contact pair or removes it; a is sampled if it has points; where voxels and points "
       "of both are chosen, so is which one is sampled; accuracy and budget_us: as of run",
       {Required("a", ValueKind::kName),
        Required("b", ValueKind::kName),
        Optional("stiffness_N_per_m", kAboveZero),
        Optional("damping_N_s_per_m", kAtLeastZero),
        Optional("friction", kAtLeastZero),
        Optional("look_ahead_m", kAtLeastZero),
        Optional("accuracy", ValueKind::kShare),
        Optional("budget_us", kAboveZero),
        Optional("active", ValueKind::kBoolean),
        Optional("collide", ValueKind::kBoolean),
        {"owner", ValueKind::kChoice, false, {"haptic", "physics"}}},
       {}},
      HingeRule(),
      SliderRule(),
      ArmRule(),
      {"links", "the links of an arm, from the base outwards; a file of its own", {}, {{"link", 1, 0}}},
      LinkRule(),
      FingersRule(),
      HandRule(),
      FingerRule(),
      JointRule(),
      SnapRule(),
      HookAndLoopRule(),
      {"parameter",
       "initial value of a named parameter",
       {Required("name", ValueKind::kName), Required("value", kPlainNumber)},
       {}},
      {"scenery",
       "what is seen only; pose of its mesh frame in W. joints: what the joints of a glTF skin go with, in its order: "
       "objects, or links of a shown arm (NAME_1 to NAME_7); then the pose is given in the first one's frame",
       {Required("name", ValueKind::kName), Required("mesh", ValueKind::kFile),
        Optional("position", ValueKind::kVector), Optional("rpy_deg", ValueKind::kVector),
        Optional("joints", ValueKind::kText), Optional("variant", ValueKind::kText)},
       {}},
      {"shown_arm",
       "an arm of seven links that is seen only: its last link's frame `flange` follows a hand; pose of its mount in "
       "W, of "
       "the flange in the palm's frame",
       {Required("name", ValueKind::kName), Required("role", ValueKind::kName), Required("links", ValueKind::kFile),
        Optional("position", ValueKind::kVector), Optional("rpy_deg", ValueKind::kVector),
        Optional("flange_position", ValueKind::kVector), Optional("flange_rpy_deg", ValueKind::kVector),
        Optional("elbow", ValueKind::kVector)},
       {}},
      {"camera",
       "a named view, in W; mounted_on: in that object's frame; follows: from that object's origin, without its turns",
       {Required("name", ValueKind::kName), Required("eye_m", ValueKind::kVector),
        Required("target_m", ValueKind::kVector), Optional("vertical_fov_deg", kAboveZero),
        Optional("mounted_on", ValueKind::kName), Optional("follows", ValueKind::kName)},
       {}},
      {"user",
       "a person whose head is tracked, for pictures that are drawn for where it is",
       {Required("name", ValueKind::kName),
        {"head", ValueKind::kChoice, false, {"simulated_head", "dtrack"}},
        Optional("address", ValueKind::kText),
        Optional("body", ValueKind::kCount),
        Optional("position", ValueKind::kVector),
        Optional("rpy_deg", ValueKind::kVector),
        Optional("eyes_m", ValueKind::kVector),
        Optional("eyes_rpy_deg", ValueKind::kVector)},
       {}},
      TactileRule(),
      {"environment",
       "where in space and when: the start of simulated time in UTC, a circular orbit (angles to the celestial "
       "equator; "
       "argument: from the node to the place at the epoch), and the zenith in W",
       {Optional("epoch", ValueKind::kInstant), Optional("altitude_km", kAboveZero),
        Optional("inclination_deg", kPlainNumber), Optional("node_deg", kPlainNumber),
        Optional("argument_deg", kPlainNumber), Optional("zenith", ValueKind::kVector)},
       {}},
      {"sun", "direction towards the sun in W at the epoch", {Required("direction", ValueKind::kVector)}, {}},
  };
}

}  // namespace

const std::vector<ElementRule>& ScenarioRules() {
  static const std::vector<ElementRule> rules = MakeRules();
  return rules;
}

}  // namespace scene
