#include "nodes/haptic_physics_node/program.hpp"

int main(int argc, char** argv) {
  return run_node::RunNodes(argc, argv, haptic_physics_node::MakeProgram(), haptic_physics_node::MakeMembers());
}
