#pragma once

#include "tools/dynamics/spinner.hpp"
#include "tools/dynamics/stack.hpp"

namespace dynamics_peers {

// MuJoCo with its three integrators of rotation.
std::vector<dynamics::SpinnerMaker> MujocoSpinners();
// MuJoCo's box contacts, with default settings and with the stiffest that it documents for this step.
std::vector<dynamics::StackMaker> MujocoStacks();

}  // namespace dynamics_peers
