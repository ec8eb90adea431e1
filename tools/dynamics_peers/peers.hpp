#pragma once

#include "tools/dynamics/spinner.hpp"
#include "tools/dynamics/stack.hpp"

namespace dynamics_peers {

// MuJoCo with its three integrators of rotation.
std::vector<dynamics::SpinnerMaker> MujocoSpinners();
// MuJoCo's contacts of boxes, as they come and with the stiffest setting that it documents for this step.
std::vector<dynamics::StackMaker> MujocoStacks();

}  // namespace dynamics_peers
