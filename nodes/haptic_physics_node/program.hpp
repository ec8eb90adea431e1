#pragma once

#include <vector>

#include "nodes/run_node/run_node.hpp"

namespace haptic_physics_node {

// What main.cpp declares about the process, and the two nodes in it.
run_node::Program MakeProgram();
std::vector<run_node::Member> MakeMembers();

}  // namespace haptic_physics_node
