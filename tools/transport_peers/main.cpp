// `oos bench bus` with LCM. Started by oos: JSON, PLOT, NAMES.
#include <cstdio>

#include "tools/transport/bench.hpp"
#include "tools/transport_peers/lcm_channel.hpp"

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "%s: started by `oos bench bus`\n", argv[0]);
    return 2;
  }
  return transport::BenchMain({argv[1], argv[2], argv[3]}, {{"LCM", transport_peers::MakeLcm}});
}
