#include "nodes/physics_node/program.hpp"

int main(int argc, char** argv) {
  return run_node::RunNode(argc, argv, physics_node::MakeProgram(), std::make_unique<physics_node::Body>());
}
