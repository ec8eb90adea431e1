#include "tools/contact/bench.hpp"

#include <unistd.h>

#include <filesystem>

#include "tools/oos/places.hpp"
#include "tools/oos/verb.hpp"

namespace oos {
namespace {

constexpr std::string_view kDetails =
    R"(For every pair of parts: times per query (median, 99th percentile, worst; contenders alternate) and the errors of force
direction, force magnitude, torque and depth against the exact answer. The table goes to stdout, all of it to the JSON
file, and one CSV and one SVG chart for each pair to the plot folder. Pairs whose meshes are missing are named and
skipped. FCL, Bullet and OpenVDB take part when `oos_bench_peers` stands beside this program: `./dev bench` builds it.)";

int Run(const Arguments& arguments) {
  if (arguments.positional()[0] != "vps") {
    return Complain("bench", "no bench '" + arguments.positional()[0] + "'; known: vps", kBadUsage);
  }
  contact::BenchOptions options;
  options.json = arguments.text("--json");
  options.plot = arguments.text("--plot");
  options.places = {arguments.text("--scenarios", "scenarios"), arguments.text("--meshes", "../shared/data/meshes")};
  options.only = arguments.text("--pair");
  const std::filesystem::path peers = ProgramFolder() / "oos_bench_peers";
  if (access(peers.c_str(), X_OK) == 0) {
    execl(peers.c_str(), peers.c_str(), options.json.c_str(), options.plot.c_str(), options.places.meshes.c_str(),
          options.places.scenarios.c_str(), options.only.c_str(), static_cast<char*>(nullptr));
    return Complain("bench", peers.string() + ": cannot be run", kBadUsage);
  }
  return contact::BenchMain(options, {});
}

}  // namespace

Verb BenchVerb() {
  return {"bench",
          "times and errors of contact queries, charted against the exact answer and other libraries",
          "vps",
          1,
          1,
          {{"--json", "FILE", "where all numbers go"},
           {"--plot", "DIR", "folder for one CSV and one SVG for each pair"},
           {"--meshes", "DIR", "public meshes; default ../shared/data/meshes"},
           {"--scenarios", "DIR", "folder of the scenarios; default scenarios"},
           {"--pair", "NAME", "only this pair"}},
          Run,
          kDetails};
}

}  // namespace oos
