// `oos bench physics` with MuJoCo. Started by oos: JSON, PLOT, NAMES.
#include <cstdio>

#include "physics/testing/mujoco_arm.hpp"
#include "tools/dynamics/bench.hpp"
#include "tools/dynamics_peers/peers.hpp"

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "%s: started by `oos bench physics`\n", argv[0]);
    return 2;
  }
  dynamics::Peers peers;
  peers.spinners = dynamics_peers::MujocoSpinners();
  peers.stacks = dynamics_peers::MujocoStacks();
  peers.arm_error = physics::test::WorstArmError;
  return dynamics::BenchMain({argv[1], argv[2], argv[3]}, peers);
}
