#include "nodes/visual_node/program.hpp"

int main(int argc, char** argv) {
  return visual_node::RunProgram(argc, argv, visual_node::CommandLineSyntax());
}
