#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "view/stereo.hpp"

namespace view {

// What can be shown over a scene. Each can be switched on and off while a run goes on.
enum class Overlay : std::uint8_t {
  kContacts,
  kTorques,
  kDepth,
  kDistance,
  kFeltForce,
  kMatrix,
  kPaths,
  kPlanned,
  kPhantom,
  kHints,
  kLatency,
  kSteps,
  kClock,
  kCamera,
  kSamples,
  kTree,
  kVoxels,
  kRobot,
  kAxes,
};

struct OverlayInfo {
  Overlay overlay;
  const char* name;  // of the parameter overlay.<name>
  char key;          // in a window, where it is on a US keyboard
  const char* what;
  bool is_on_at_start = false;
};

inline constexpr std::array<OverlayInfo, 19> kOverlays = {{
    {Overlay::kContacts, "contacts", 'C', "contact forces", true},
    {Overlay::kTorques, "torques", 'T', "torques of contacts about the part that touches"},
    {Overlay::kDepth, "depth", 'Z', "contact points, coloured by how deep they penetrate"},
    {Overlay::kDistance, "distance", 'N', "distances of surfaces that nearly touch"},
    {Overlay::kFeltForce, "felt_force", 'F', "force and torque on each hand, the grasp included"},
    {Overlay::kMatrix, "matrix", 'M', "table of who touches whom"},
    {Overlay::kPaths, "paths", 'R', "where what moves has been"},
    {Overlay::kPlanned, "planned", 'U', "where the step of the procedure wants parts to go"},
    {Overlay::kPhantom, "phantom", 'G', "the device's pose, where the tool cannot follow it"},
    {Overlay::kHints, "hints", 'H', "the instruction at the part that it names"},
    {Overlay::kLatency, "latency", 'L', "latency and late cycles over time"},
    {Overlay::kSteps, "steps", 'I', "steps of the procedure with their times"},
    {Overlay::kClock, "clock", 'K', "simulated time against the wall clock"},
    {Overlay::kCamera, "camera", 'O',
     "what the first camera that is mounted on a part sees, in a corner of the window"},
    {Overlay::kSamples, "samples", ',', "points of the selected part that are tested for contact"},
    {Overlay::kTree, "tree", '.', "a level of spheres over the selected part's points"},
    {Overlay::kVoxels, "voxels", 'V', "voxels through which the selected part's surface passes"},
    {Overlay::kRobot, "robot", ';', "devices that are robots: joints, torques off their command, the motion's target"},
    {Overlay::kAxes, "axes", '=', "axes of the world, of the selected part and of each hand"},
}};

using OverlaySet = std::bitset<kOverlays.size()>;

constexpr std::size_t IndexOf(Overlay overlay) {
  return static_cast<std::size_t>(overlay);
}

// Those that are on at the start.
OverlaySet DefaultOverlays();
// By name; none: unknown.
std::optional<Overlay> FindOverlay(std::string_view name);
std::optional<Overlay> FindOverlayOfKey(char key);

// What a person has chosen to see.
struct Choices {
  struct Object {
    bool is_hidden = false;
    bool is_transparent = false;
    bool is_highlighted = false;
  };
  OverlaySet overlays = DefaultOverlays();
  std::vector<Object> objects;  // by index; those beyond the end are shown as they are
  int selected = -1;            // object whose properties are listed; -1: none
  Stereo stereo = Stereo::kNone;
  double eye_distance_m = kEyeDistance_m;

  [[nodiscard]] bool has(Overlay overlay) const { return overlays[IndexOf(overlay)]; }
};

// What can be done with the selected part.
struct PartChoice {
  bool Choices::Object::*flag;
  const char* name;  // of the parameter <name>.<object>
  char key;          // in a window, as of overlays
  const char* what;  // of a part
};
inline constexpr std::array<PartChoice, 3> kPartChoices = {{
    {&Choices::Object::is_hidden, "hide", 'X', "hidden"},
    {&Choices::Object::is_transparent, "transparent", 'B', "transparent"},
    {&Choices::Object::is_highlighted, "highlight", '/', "highlighted"},
}};

// Choices by name, as `oos set` changes them (1: yes, 0: no): overlay.<name>, stereo.<mode>, and hide.<object>,
// transparent.<object>, highlight.<object>, select.<object>. One object at most is selected, and one mode.
std::vector<std::string> ChoiceNames(const std::vector<std::string>& objects);
// False, without a change, when there is no such choice.
bool SetChoice(const std::string& name, bool is_on, const std::vector<std::string>& objects, Choices* choices);

// From a list like "paths no_contacts hide.cover", separated by blanks or commas: choices by name, overlays without
// their prefix, "no_" before what is not wanted. Error: kInvalidInput, with the nearest right name.
core::Result<Choices> ReadChoices(const std::string& list, const std::vector<std::string>& objects);

}  // namespace view
