#include <cstdio>

#include "tools/contact/bench.hpp"
#include "tools/contact_peers/peers.hpp"

// `oos bench vps` runs this in its own place where it exists. Arguments: JSON file, plot folder, meshes, scenarios, one
// pair or "".
int main(int argc, char** argv) {
  if (argc != 6) {
    std::fprintf(stderr, "oos_bench_peers: run `oos bench vps`, which runs this\n");
    return 2;
  }
  std::vector<contact::Contender> all = contact::OwnContenders();
  for (const double factor : {2.0, 1.0, 0.5}) {
    char setting[64];
    std::snprintf(setting, sizeof(setting), "%g s; 16384 points", factor);
    all.push_back({"OpenVDB", setting, [=](const contact::Workload& w) {
                     return contact_peers::MakeOpenvdbMethod(w.A, w.B, factor * w.voxel_size_m, 16384);
                   }});
  }
  all.push_back({"FCL", "all contacts",
                 [](const contact::Workload& w) { return contact_peers::MakeFclMethod(w.A, w.B); }, false});
  all.push_back({"GImpact", "margin 0",
                 [](const contact::Workload& w) { return contact_peers::MakeGimpactMethod(w.A, w.B); }, false});
  return contact::BenchMain({argv[1], argv[2], argv[3], argv[4], argv[5]}, all);
}
