#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/hand_guide.hpp"
#include "core/messages/trace.hpp"
#include "core/pose.hpp"
#include "core/result.hpp"
#include "scene/scenario.hpp"
#include "space/surroundings.hpp"
#include "view/overlay_shapes.hpp"

namespace view {

// What is visible, independent of how it is drawn (architecture D17). A renderer reads a Scene and nothing else.
// SI units, world frame W with z up. Colours are linear RGB.

struct Material {
  glm::vec3 base_color{0.8f};
  float metallic = 0.0f;
  float roughness = 0.6f;
  glm::vec3 emissive{0.0f};
  float coat = 0.0f;  // the share that clear lacquer or glass covers
  float coat_roughness = 0.0f;
  bool is_foil = false;  // of multi-layer insulation: wrinkled, and rolled in one direction
};

inline constexpr glm::vec3 kHighlight{1.0f, 0.55f, 0.05f};

// Where the joints of a skin are in its mesh frame, in the order of the mesh file. Shared, because a scene is copied at
// the rate of the bus; another posture is another object.
using Posture = std::shared_ptr<const std::vector<core::Pose>>;

// One mesh in the world. Plain data, because a scene is copied at the rate of the bus.
struct Instance {
  std::uint32_t mesh = 0;  // index into Assets::meshes
  core::Pose X_WM;         // M: the mesh frame
  Posture posture;         // none: rigid, or as the file has it. Of a skin no other instance has the same `mesh`
  Material material;
  bool is_material_given = false;  // false: the mesh file's own materials are used, with `emissive` added
  bool is_visible = true;
  bool is_movable = false;  // may move from frame to frame
  bool is_scenery = false;  // no object of the scenario: <scenery>, or a link of a <shown_arm>
  float opacity = 1.0f;     // below 1: drawn as a phantom at its own pose
  float highlight = 0.0f;   // of kHighlight over the instance's own surface
};

// A deformable sheet: nodes in W, row by row. Both of its sides are visible.
struct Sheet {
  std::uint32_t instance = 0;  // of the object that it belongs to
  std::uint32_t num_columns = 0;
  std::vector<glm::vec3> p_W;
  Material material;
  std::uint64_t version = 0;  // changes whenever p_W does
  bool is_visible = true;
};

// A signal lamp: it glows and lights what is near.
struct Lamp {
  std::uint32_t instance = 0;
  glm::vec3 color{0.0f};
};

enum class TextStyle : std::uint8_t { kSmall, kBody, kTitle, kBadge };

// A line of text over the picture. Lines of one anchor are stacked from the top to the bottom in their order.
struct TextLine {
  Anchor anchor = Anchor::kTopLeft;
  TextStyle style = TextStyle::kSmall;
  glm::vec3 color{1.0f};
  std::string text;
};

// An instance whose mesh has a skin: each of its joints goes with an instance.
struct Skin {
  std::uint32_t instance = 0;
  core::Pose X_JM;  // in the frame of its first joint
  std::vector<std::uint32_t> goes_with;
};

// Constant for the whole run; shared by all copies of a scene.
struct Assets {
  std::vector<std::filesystem::path> meshes;
  std::vector<std::string> instance_names;
  std::vector<std::string> variants;  // of each instance: which look of its mesh file; empty: the first
  std::vector<scene::Camera> cameras;
  std::vector<Skin> skins;
};

// Where a person who steers a hand goes next, from where the hand is.
struct HandGuide {
  core::GuideKind kind = core::GuideKind::kNone;
  glm::dvec3 way_W_m{0.0};
  glm::dvec3 turn_W_rad{0.0};
};

struct Scene {
  std::shared_ptr<const Assets> assets;
  space::Surroundings space;  // of the sun, the Earth and the stars, at that time
  std::vector<Instance> instances;
  std::vector<Sheet> sheets;
  std::vector<Lamp> lamps;
  std::vector<Arrow> arrows;
  std::vector<RingArrow> rings;
  std::vector<LineStrip> lines;
  std::vector<PointSet> points;
  std::vector<Cubes> cubes;
  std::vector<Spheres> spheres;
  std::vector<Label> labels;
  std::vector<Axes> axes;
  std::vector<Phantom> phantoms;
  std::vector<Graph> graphs;
  std::vector<TextLine> texts;
  std::vector<double> felt_N;     // per role: size of the force that is commanded to its device
  std::vector<HandGuide> guides;  // per role; empty: nobody steers

  // The moment that the scene shows.
  std::string step;  // active procedure step
  bool is_final = false;
  bool is_failed = false;
  std::int64_t time_ns = 0;     // simulated time of the newest physics state
  core::Trace direct;           // of the newest physics state, stamped up to kVisualApply
  core::Trace through_physics;  // of the same state
};

// Poses and postures of the skins, from where the instances of their joints are. A posture that has not changed stays
// the same object: then nothing is bent anew.
void MoveSkins(Scene* scene);

// Index of the camera of that name; -1: none.
int FindCamera(const Assets& assets, const std::string& name);
// The camera to look through during a procedure step: `fixed` when it names one, else the one named after the step,
// else the first.
const scene::Camera& CameraFor(const Assets& assets, const std::string& fixed, const std::string& step);
// The camera in W, where its object stands now.
scene::Camera PlaceCamera(const scene::Camera& camera, const Scene& scene);
// The same view, carried by an object from now on. `placed` is in W.
scene::Camera Follow(const scene::Camera& placed, int object, const Scene& scene);
// A line of a scenario file: <camera name="..." .../>.
std::string CameraXml(const scene::Camera& camera, const Assets& assets);
// Error: kInvalidInput, naming all cameras, unless `name` is empty or one of them.
core::Result<void> CheckCamera(const Assets& assets, const std::string& name);

}  // namespace view
