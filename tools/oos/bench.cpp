#include "tools/contact/bench.hpp"

#include <unistd.h>

#include <filesystem>

#include "tools/oos/places.hpp"
#include "tools/oos/verb.hpp"

namespace oos {
namespace {

constexpr std::string_view kDetails =
    R"(Every query figure of the contact engine, on one core, with the goals that it must hold. For every pair of parts, hands'
motions of consecutive poses and independent poses: times (median, 99th percentile, worst; contenders take turns) and
errors of force direction, magnitude, torque and depth against the exact answer. Then scaling with points and with
pairs, the walk beside a flat scan and the machine's random reads, instruction sets, the field's accuracy, the ripple of
a slide. Tables go to stdout, all of it to the JSON file, and a CSV beside each SVG chart to the plot folder. Parts whose
meshes are missing are named and skipped. FCL, Bullet and OpenVDB take part when `oos_bench_peers` stands beside this
program: `./dev bench` builds it.)";

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
           {"--plot", "DIR", "folder for the charts (SVG) and their tables (CSV)"},
           {"--meshes", "DIR", "public meshes; default ../shared/data/meshes"},
           {"--scenarios", "DIR", "folder of the scenarios; default scenarios"},
           {"--pair", "NAMES", "only these parts and studies, with commas; a wrong name lists all"}},
          Run,
          kDetails};
}

}  // namespace oos
