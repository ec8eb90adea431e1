#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "scene/scenario.hpp"
#include "view/choices.hpp"
#include "view/scene.hpp"

namespace visual_node {

// What collision sees of an object [VR-OOS, Fig. 4]: its points, a level of the spheres over them, and the voxels of
// its surface, by the scenario's method. Object frame.
struct Structures {
  view::SharedPoints points_O;
  float spacing_m = 0.0f;  // of the points, typically
  std::shared_ptr<const std::vector<glm::vec4>> spheres_O;
  view::SharedPoints voxels_O;
  double voxel_size_m = 0.0;
  std::size_t level = 0, num_levels = 0;  // of the spheres that are shown; 0 is the root
  std::string error;                      // instead of all of them
};

// From the cache, or built and put there.
Structures BuildStructures(const scene::Scenario& scenario, std::size_t object);

// Shows the structures of the selected object.
class StructureShow {
 public:
  explicit StructureShow(const scene::Scenario& scenario) : scenario_(scenario) {}
  ~StructureShow();
  StructureShow(const StructureShow&) = delete;
  StructureShow& operator=(const StructureShow&) = delete;

  // Adds what is chosen to the scene, and builds it in a thread of low priority meanwhile; until then a line of text
  // says so.
  void AddTo(const view::Choices& choices, view::Scene* scene);
  // For pictures: waits until it is built.
  void BuildAndAddTo(const view::Choices& choices, view::Scene* scene);

 private:
  [[nodiscard]] static bool IsWanted(const view::Choices& choices);
  void Show(const view::Choices& choices, view::Scene* scene) const;
  void Begin(int object);

  const scene::Scenario& scenario_;
  int object_ = -1;  // whose structures are there or in work
  std::optional<Structures> built_;
  Structures in_work_;  // belongs to the thread until it is done
  std::atomic<bool> is_done_{false};
  std::thread thread_;
};

}  // namespace visual_node
