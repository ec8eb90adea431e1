// `oos bench stability` with MuJoCo. Started by oos: JSON, PLOT, NAMES.
#include <cstdio>

#include "tools/failures/bench.hpp"
#include "tools/failures_peers/mujoco_loop.hpp"

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "%s: started by `oos bench stability`\n", argv[0]);
    return 2;
  }
  return failures::BenchMain({argv[1], argv[2], argv[3]}, {failures_peers::MujocoPeer()});
}
