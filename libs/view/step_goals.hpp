#pragma once

#include <map>
#include <string>
#include <vector>

#include "scene/scenario.hpp"
#include "view/scene.hpp"

namespace view {

// What a step of the procedure is to bring about: a snap that engages, or a hand that holds an object.
struct StepGoal {
  int mechanism = -1;  // index into Scenario::mechanisms; -1: a grasp
  int palm = -1;       // objects of a grasp
  int object = -1;
};

// By step: of the conditions `SNAP.state == 1` and `ROLE.grasped.OBJECT == 1` of its transitions. Empty when the
// procedure cannot be read; logic_node reports why.
std::map<std::string, std::vector<StepGoal>> ReadStepGoals(const scene::Scenario& scenario);

// A straight way for each goal that is not reached: of a part to before its socket, along the socket's axis to its
// seat, and the part there as a phantom; of a palm to the object.
void AddPlannedWays(const scene::Scenario& scenario, const std::vector<StepGoal>& goals, Scene* scene);

}  // namespace view
