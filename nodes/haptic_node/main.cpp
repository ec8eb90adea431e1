#include "nodes/haptic_node/program.hpp"

int main(int argc, char** argv) {
  return run_node::RunNode(argc, argv, haptic_node::MakeProgram(), std::make_unique<haptic_node::Body>());
}
