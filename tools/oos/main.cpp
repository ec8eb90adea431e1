#include "tools/oos/command_line.hpp"

int main(int argc, char** argv) {
  return oos::RunCommandLine(std::vector<std::string>(argv + 1, argv + argc));
}
