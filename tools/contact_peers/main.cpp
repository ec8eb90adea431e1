#include <cstdio>
#include <string_view>

#include "tools/contact/bench.hpp"
#include "tools/contact_peers/build_comparison.hpp"
#include "tools/contact_peers/peers.hpp"
#include "tools/contact_peers/study_build.hpp"

// `oos bench vps` runs this program instead of itself where it is installed. Arguments: JSON file, plot folder, meshes,
// scenarios, names of parts and studies or "". StudyBuild runs this program again with kBuildVerb.
int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == contact_peers::kBuildVerb) return contact_peers::BuildOnce(argc, argv);
  if (argc != 6) {
    std::fprintf(stderr, "oos_bench_peers: run `oos bench vps`, which runs this\n");
    return 2;
  }
  contact::Peers peers;
  const auto add = [&](const char* method, const char* setting, const char* mark, bool has_magnitude, auto make) {
    contact::Contender c;
    c.method = method;
    c.setting = setting;
    c.mark = mark;
    c.has_magnitude = has_magnitude;
    c.make = make;
    peers.contenders.push_back(std::move(c));
  };
  using contact::Parts;
  using contact::Structures;
  for (const auto& [factor, setting, mark] :
       {std::tuple{1.0, contact::kMiddle, ""}, {2.0, "2 s; 65536 points", "2s"}, {0.5, "s/2; 65536 points", "s/2"}}) {
    add("OpenVDB", setting, mark, true, [factor = factor](const Parts& parts, Structures& structures) {
      return contact_peers::MakeOpenvdbMethod(parts, factor * parts.voxel_size_m, &structures);
    });
  }
  add("FCL", "all contacts", "", false,
      [](const Parts& parts, Structures&) { return contact_peers::MakeFclMethod(parts.A, parts.B); });
  add("GImpact", "margin 0", "", false,
      [](const Parts& parts, Structures&) { return contact_peers::MakeGimpactMethod(parts.A, parts.B); });
  add("convex parts", "HACD", "", false,
      [](const Parts& parts, Structures&) { return contact_peers::MakeConvexPartsMethod(parts.A, parts.B); });
  add("GJK/EPA", "hulls", "", false,
      [](const Parts& parts, Structures&) { return contact_peers::MakeHullMethod(parts.A, parts.B); });
  peers.study_build = contact_peers::StudyBuild;
  contact::BenchOptions options;
  options.json = argv[1];
  options.plot = argv[2];
  options.places = {argv[4], argv[3]};
  options.only = argv[5];
  return contact::BenchMain(options, peers);
}
