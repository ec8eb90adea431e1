#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "space/place.hpp"

namespace scene {

// The checked model of a scenario file. Plain data in SI units and radians. Indices into `objects`, `pairs` and
// `mechanisms` are the ids used on the bus; they are in file order, so processes that read the same file agree.
//
// Defaults are choices for hand-sized parts of about a kilogram at 1 kHz, and the scenarios' starting point; no study
// selected them. Where a value comes from elsewhere, its line says so.

// Which node owns an object's pose: none (fixed), physics_node, or haptic_node (a part of a hand).
enum class Owner { kFixed, kPhysics, kHand };

// A hand is a palm and two jaws. At opening w the jaws stand at -w/2 and +w/2 along the palm's x axis;
// at opening 0 the three mesh frames coincide.
enum class HandPart { kNone, kPalm, kJawLeft, kJawRight };

// How physics_node uses contacts: the paper's first way (wrench), its second way (hard contact), or compliant planes
// with look-ahead (architecture D5).
enum class ContactInput { kWrench, kManifold, kPlanes };

// Which node computes a pair's contact: haptic_node, which sends it to physics_node, or physics_node itself, without
// transport delay. Pairs of a hand's part are always haptic_node's, those of a finger's link physics_node's.
enum class PairOwner { kHaptic, kPhysics };

struct Location {  // line of a file, for diagnostics
  std::filesystem::path file;
  int line = 0;
};

struct Material {
  glm::vec3 base_color{0.8f};
  float metallic = 0.0f;
  float roughness = 0.6f;
  bool is_given = false;  // false: the glTF file's own material is used
  std::string variant;    // then: which of its looks; empty: the first
};

// A named frame fixed in an object's mesh frame, e.g. a tool tip or a socket; operator scripts and snaps refer to it.
struct Frame {
  std::string name;
  core::Pose X_OF;
};

// A deformable sheet that is sewn to an object, as a cover is to its tab: flat at the start, in the xy plane of S.
// Nodes inside the seam, a rectangle about the object's origin, are held to the object by springs whose total stiffness
// is given. A hook_and_loop whose child is the object acts on the sheet instead of the object.
struct Sheet {
  core::Pose X_OS;
  double size_x_m = 0.0;
  double size_y_m = 0.0;
  int cells_x = 0;
  int cells_y = 0;
  double density_kg_per_m2 = 0.5;
  double stretch_stiffness_N_per_m = 4000.0;
  double bending_stiffness_Nm = 0.002;
  double thickness_m = 0.002;
  double friction = 0.3;
  double damping_per_s = 4.0;
  double seam_x_m = 0.0;
  double seam_y_m = 0.0;
  double seam_stiffness_N_per_m = 1000.0;
  double seam_damping_N_s_per_m = 8.0;
  double grip_stiffness_N_per_m = 1000.0;  // of jaws that pinch the sheet: total over all gripped nodes
  double grip_damping_N_s_per_m = 8.0;
  Material material;
  bool is_active = true;  // initial; an inactive sheet neither moves nor exerts forces
  Location location;
};

struct Inertia {
  glm::dvec3 p_OCm_m{0.0};
  glm::dmat3 I_Cm_O_kg_m2{0.0};  // about the centre of mass, in the mesh frame's axes
};

// A hand's fingers, thumb first, and the joints of each, from the palm outwards. The thumb's first joint is its
// opposition, all others flex; 0 is a straight finger, and a thumb beside the palm.
constexpr int kFingers = 5;
constexpr int kJointsPerFinger = 3;
constexpr int kFingerJoints = kFingers * kJointsPerFinger;

// What a <fingers> element makes of an object: a link of a finger, and how its pad touches.
struct FingerLink {
  int role = -1;   // index into Scenario::devices
  int finger = 0;  // 0: the thumb
  double friction = 0.0;
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;
};

struct Object {
  std::string name;
  Owner owner = Owner::kFixed;
  HandPart part = HandPart::kNone;
  int role = -1;      // index into Scenario::devices for a hand part
  std::string group;  // members of one group are never tested against each other [VR-OOS, section 3]
  std::filesystem::path visual_mesh;
  std::filesystem::path collision_mesh;  // empty: none
  Material material;
  core::Pose X_WO;       // initial pose of the mesh frame
  core::Twist V_WO;      // initial velocity of its origin; physics objects
  double mass_kg = 0.0;  // one of mass and density is given for physics objects
  double density_kg_per_m3 = 0.0;
  std::optional<Inertia> inertia;     // none: computed from the mesh
  double voxel_size_m = 0.0;          // 0: no voxelmap
  std::uint32_t num_points = 0;       // 0: no pointshell
  bool is_resolution_chosen = false;  // the file gives neither: collision::ChooseResolutions does, for its pairs
  double sheet_thickness_m = 0.0;     // 0: the mesh bounds a solid; else it is a thin sheet with two sides
  std::vector<Frame> frames;
  std::optional<Sheet> sheet;
  std::optional<FingerLink> finger_link;
  bool is_lamp = false;  // logic_node sets its colour
  glm::vec3 lamp_color{0.0f};
  Location location;
};

// Of a pair, unless the scenario says otherwise. A hand does not tell forces apart that differ by less than 7 to 10 %
// (Jones 2000). The budget is not derived: a fraction of a haptic cycle.
constexpr double kUsualAccuracy = 0.1;
constexpr double kUsualBudget_us = 60.0;

// Contact pair: S's pointshell against G's voxelmap.
struct Pair {
  std::uint16_t sampled = 0;
  std::uint16_t field = 0;
  double stiffness_N_per_m = 2.0e4;
  double damping_N_s_per_m = 20.0;
  double friction = 0.2;
  double look_ahead_m = 0.002;
  // Method `fast`: wanted error of the force, over the integral of depth, and the time that may be spent on it in one
  // cycle, on a usual processor (so many places of the field, so that results do not depend on the machine).
  double accuracy = kUsualAccuracy;
  double budget_us = kUsualBudget_us;
  bool is_active = true;  // initial entry of the state matrix
  PairOwner owner = PairOwner::kHaptic;
  Location location;
};

enum class MechanismKind { kHinge, kSlider, kSnap, kHookAndLoop };

// Hinge: J frames coincide at angle 0; rotation about z of J, from parent to child. The child's X_WO in the model is
// that at its start angle. With two detents it is a toggle switch: the torque acts towards the nearer detent, is zero
// half way, and peaks at `detent_torque_Nm`. Without detents it turns freely between its limits.
//
// Slider: J frames coincide at position 0; the child moves along z of J.
//
// Snap: pulls the origin of J_child to that of J_parent; z of J_parent points out of the socket, `position` is the
// child's z coordinate in J_parent. It acts while the child is within `guide_length_m` of the seat and inside the
// lateral and tilt tolerances. Along the guide it is a slider (lateral and angular springs). Near the seat it has the
// snap profile: insertion past `travel_m` takes up to `engage_force_N`, removal up to `release_force_N`. While engaged,
// springs in all six degrees of freedom hold the child.
//
// Hook-and-loop: patches at points given in the parent's frame, each a spring that breaks at `release_force_N`.
struct Mechanism {
  std::string name;
  MechanismKind kind = MechanismKind::kHinge;
  int parent = -1;  // object index; -1: world
  int child = -1;
  core::Pose X_PJ;       // J in the parent's mesh frame (world for -1)
  core::Pose X_CJ;       // J in the child's mesh frame
  double damping = 0.0;  // hinge: Nm s/rad; others: N s/m (about an axis: times the square of a lever of 0.05 m)

  // hinge (rad, rad/s, Nm) and slider (m, m/s, N)
  double lower = -1e9;
  double upper = 1e9;
  double motor_speed = 0.0;  // target speed of the child relative to the parent
  double motor_limit = 0.0;  // largest torque or force of the motor; 0: no motor
  bool is_locked = false;    // held at its start position

  // hinge of a finger: a servo turns it to an angle of the device, with at most motor_limit
  int finger_role = -1;   // index into Scenario::devices; -1: none
  int finger_joint = -1;  // index into core::DeviceState::finger_rad
  double servo_stiffness_Nm_per_rad = 0.0;
  double servo_damping_Nm_s_per_rad = 0.0;
  double start_rad = 0.0;  // until the device has told an angle

  // hinge
  std::vector<double> detents_rad;  // none or two, ascending
  double detent_torque_Nm = 0.0;
  int initial_detent = 0;

  // snap
  double engage_force_N = 0.0;
  double release_force_N = 0.0;
  double travel_m = 0.003;
  // Measured force profile, as points (distance from the seat [m], force against insertion [N]). Empty: half a sine of
  // amplitude engage_force_N over travel_m. With a profile these two are its largest force and its last distance.
  std::vector<glm::dvec2> profile;
  double guide_length_m = 0.0;
  double lateral_tolerance_m = 0.001;
  double tilt_tolerance_rad = 0.035;
  double stiffness_N_per_m = 0.0;  // lateral and, when engaged, axial
  double stiffness_Nm_per_rad = 0.0;
  bool is_initially_engaged = false;

  // hook-and-loop (release_force_N and stiffness_N_per_m are per patch)
  std::vector<glm::dvec3> patches_m;  // in the parent's mesh frame

  Location location;
};

constexpr const char* kDeviceTypes[] = {"simulated_arm", "simulated_hug", "simulated_hand", "hug",   "udp",
                                        "serial",        "plugin",        "replay",         "haply", "dtrack"};

// A hand device and its role. Role names are chosen by the scenario ("op1/arm.left").
struct Device {
  std::string role;
  std::string type = "simulated_arm";                        // of kDeviceTypes
  std::string address;                                       // where a device of type udp, serial, plugin or replay is
  std::vector<std::pair<std::string, std::string>> options;  // for a plug-in: name and value
  int palm = -1;                                             // object index
  int jaw_left = -1;
  int jaw_right = -1;
  core::Pose X_WD_start;
  double mass_kg = 1.5;  // apparent, with feed-forward; assumed, as no figure for the HUG device is published
  double inertia_kg_m2 = 0.03;
  double damping_N_s_per_m = 5.0;
  double damping_Nm_s_per_rad = 0.05;
  double opening_max_m = 0.08;
  double opening_start_m = 0.06;
  double command_delay_s = 0.0;           // configurable transport delay of the arm
  double hand_stiffness_N_per_m = 800.0;  // impedance of the operator's arm; assumed
  double hand_damping_N_s_per_m = 60.0;
  double hand_stiffness_Nm_per_rad = 25.0;
  double hand_damping_Nm_s_per_rad = 1.2;
  double max_force_N = 50.0;  // limits of the safety filter (nodes/device_bridge/safety_filter.hpp)
  double max_torque_Nm = 8.0;
  double max_force_rate_N_per_s = 20000.0;
  Location location;
};

// Virtual coupling and force parameters of the paper [VR-OOS, Eq. 2-6]. The paper sets eta, sigma, rho and alpha
// empirically to the values here; it gives no stiffness.
struct Coupling {
  std::string type = "paper";          // or god_object, which has no eta and sigma
  double stiffness_N_per_m = 2500.0;   // k_f
  double stiffness_Nm_per_rad = 30.0;  // k_t
  double eta = 0.2;                    // filter constant of Eq. 3
  double sigma_m2 = 0.035;             // inertia over mass in Eq. 4
  double rho = 0.01;                   // expected fraction of colliding points in Eq. 2
  double alpha = 2.0;                  // exponent of Eq. 2
  // Spring between gripper and grasped object (architecture, ownership). A hand that swings a mass m by it with
  // frequency w feels m a / (1 - m w^2 / K): 5 % more than m a for 2 kg at 2 Hz wants K > 21 m w^2, 6.6 kN/m. The
  // largest K with which the hand is at rest on a wall over a link that is late by 3 ms each way is measured in row H4
  // of docs/performance/stability.md.
  double grasp_stiffness_N_per_m = 8000.0;
  double grasp_damping_N_s_per_m = 65.0;  // a quarter of critical damping for 2 kg
  double grasp_stiffness_Nm_per_rad = 100.0;
  double grasp_damping_Nm_s_per_rad = 1.0;
  double jaw_stiffness_N_per_m = 8000.0;  // on the gripper axis
  bool is_grip_by_friction =
      false;                   // jaws hold what their force and the pairs' friction hold; else whatever they grasp
  bool is_reevaluated = true;  // the force is made anew when physics answers (HapticNode::Reevaluate)
  bool has_field = true;       // the bridge lets the force follow the device between commands (god_object only)
};

// In W; or mounted on an object, in its mesh frame; or following an object, from its origin along W's axes.
struct Camera {
  std::string name;
  glm::dvec3 eye_m{0.0, -1.0, 1.0};
  glm::dvec3 target_m{0.0};
  double vertical_fov_rad = 0.8;
  int object = -1;          // that it is mounted on or follows; -1: none
  bool is_mounted = false;  // turns with its object
  glm::dvec3 up{0.0};       // upwards in the picture; zero: z, or y when the camera looks along z
};

// A person whose head is tracked, for pictures that are drawn for where it is (topic user/<name>/head).
struct User {
  std::string name;
  std::string head = "simulated_head";
  // Of head "dtrack": where it sends (PORT or GROUP:PORT), the number of the body, where the tracker's room frame T
  // stands in the viewer's room R, and how the head H sits in the body's frame: its origin between the eyes, x to the
  // right, y ahead, z up.
  std::string address;
  int body = 0;
  core::Pose X_RT;
  core::Pose X_BH;
  Location location;
};

// A device that lets a person feel on the skin what a body touches, and nothing of its force.
struct Tactile {
  std::string name;
  std::string type = "simulated";     // or usb
  std::filesystem::path device_file;  // what it is and what it is sent (libs/tactile/README.md)
  int body = -1;                      // object index
  core::Pose X_OB;                    // on the body: z along the limb, x towards channel 0
  // Full intensity at this depth; or at this force, when that is given.
  double full_depth_m = 0.003;
  double full_force_N = 0.0;
  Location location;
};

// What is seen only: it has no collision mesh and no id on the bus.
struct Scenery {
  std::string name;
  std::filesystem::path mesh;
  core::Pose X_WM;  // with joints: in the first one's frame instead of W
  // What the joints of a skin go with: objects, or links of shown arms ("NAME_1" to "NAME_7").
  std::vector<std::string> joints;
  std::string variant;  // as Material's
};

// An arm that is seen only. Its posture follows from where a hand's palm is (view::ArmPosture).
struct ShownArm {
  static constexpr std::size_t kNumLinks = 7;
  struct Link {
    core::Pose X_PJ;  // its joint, about z, in the link before; the first one's in B
    std::filesystem::path visual_mesh;
    Material material;
  };

  std::string name;
  int role = -1;                      // index into Scenario::devices
  core::Pose X_WB;                    // where the arm is mounted
  core::Pose X_7F;                    // the flange in the last link
  core::Pose X_PalmF;                 // where the hand is mounted on it
  glm::dvec3 elbow_W{0.0, 0.0, 1.0};  // the way that the elbow points
  std::array<Link, kNumLinks> links;

  [[nodiscard]] std::string LinkName(std::size_t link) const { return name + "_" + std::to_string(link + 1); }
};

struct Parameter {
  std::string name;
  double value = 0.0;
};

struct Scenario {
  std::string name;
  std::string title;
  std::filesystem::path file;       // absolute
  std::filesystem::path folder;     // of the file; relative paths in it are relative to this
  std::filesystem::path procedure;  // SCXML
  std::filesystem::path operator_script;
  std::string method = "paper";
  // Of pairs that do not have their own.
  double accuracy = kUsualAccuracy;
  double budget_us = kUsualBudget_us;
  ContactInput contact_input = ContactInput::kPlanes;
  std::uint64_t seed = 1;
  double duration_limit_s = 120.0;
  double stall_limit_s = 20.0;       // a procedure step that takes longer is reported as a failure
  double force_cap_N = 40.0;         // initial value of the parameter of that name; logic_node may lower it in a state
  glm::dvec3 gravity_m_per_s2{0.0};  // in W; felt by what physics moves: devices carry their own weight
  space::Place place;                // <environment> and <sun>
  Coupling coupling;
  std::vector<Device> devices;
  std::vector<Object> objects;
  std::vector<Pair> pairs;
  std::vector<Mechanism> mechanisms;
  std::vector<Camera> cameras;
  std::vector<User> users;
  std::vector<Tactile> tactiles;
  std::vector<Scenery> scenery;
  std::vector<ShownArm> shown_arms;
  std::vector<Parameter> parameters;              // initial values of further named parameters
  std::vector<std::filesystem::path> hand_files;  // of <fingers>: what objects and mechanisms were made of

  // Indices; -1: none.
  [[nodiscard]] int FindObject(const std::string& object_name) const;
  [[nodiscard]] int FindMechanism(const std::string& mechanism_name) const;
  [[nodiscard]] int FindRole(const std::string& role) const;
  [[nodiscard]] int FindTactile(const std::string& tactile) const;
  [[nodiscard]] std::string PairName(std::size_t pair_index) const;    // "sampled/field"
  [[nodiscard]] const char* PairSource(std::size_t pair_index) const;  // the node that computes and publishes it
};

// Names of a mechanism's quantities that can be changed at run time as parameters "<mechanism>.<name>".
std::vector<const char*> LiveFigures(const Mechanism& mechanism);

// Pose X_WPart of a hand's part, for the palm's pose and an opening [m]; see HandPart.
core::Pose PartPose(HandPart part, const core::Pose& X_WPalm, double opening_m);

}  // namespace scene
