#include "tools/contact/bench.hpp"

#include <unistd.h>

#include <filesystem>

#include "tools/dynamics/bench.hpp"
#include "tools/oos/places.hpp"
#include "tools/oos/verb.hpp"
#include "tools/transport/bench.hpp"

namespace oos {
namespace {

constexpr std::string_view kDetails =
    R"(vps: every query figure of the contact engine, on one core, with the goals that it must hold. For every pair of
parts, hands' motions of consecutive poses and independent poses: times (median, 99th percentile, worst; contenders take turns) and
errors of force direction, magnitude, torque and depth against the exact answer. Then scaling with points and with
pairs, the walk beside a flat scan and the machine's random reads, instruction sets, the field's accuracy, the ripple of
a slide. Tables go to stdout, all of it to the JSON file, and a CSV beside each SVG chart to the plot folder. Parts whose
meshes are missing are named and skipped. FCL, Bullet and OpenVDB take part when `oos_bench_peers` stands beside this
program: `./dev bench` builds it.

physics: the dynamics beside closed forms and Bullet: rotation, rebound under delay, reduction of contacts, mass ratio,
a peg that jams, sheets. MuJoCo takes part when `oos_bench_dynamics_peers` stands beside this program.

bus: one hop by transport and size, classes of topics, the age of the newest sample while packets are lost between two network
namespaces (root), throughput, processor time and blocks: the bus, encrypted and not, beside raw UDP, raw ZeroMQ and shared memory. LCM
takes part when `oos_bench_transport_peers` stands beside this program.)";

// Runs in place of this program if it stands beside it; else returns.
void RunPeers(const char* name, std::vector<std::string> words) {
  const std::filesystem::path program = ProgramFolder() / name;
  if (access(program.c_str(), X_OK) != 0) return;
  words.insert(words.begin(), program.string());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  execv(program.c_str(), pointers.data());
  Complain("bench", program.string() + ": cannot be run; going on without it", kBadUsage);
}

bench::BenchOptions OptionsOf(const Arguments& arguments) {
  return {arguments.text("--json"), arguments.text("--plot"), arguments.text("--pair")};
}

int RunPhysics(const Arguments& arguments) {
  const bench::BenchOptions options = OptionsOf(arguments);
  RunPeers("oos_bench_dynamics_peers", {options.json, options.plot, options.only});
  return dynamics::BenchMain(options, {});
}

int RunBus(const Arguments& arguments) {
  const bench::BenchOptions options = OptionsOf(arguments);
  RunPeers("oos_bench_transport_peers", {options.json, options.plot, options.only});
  return transport::BenchMain(options, {});
}

int Run(const Arguments& arguments) {
  if (arguments.positional()[0] == "physics") return RunPhysics(arguments);
  if (arguments.positional()[0] == "bus") return RunBus(arguments);
  if (arguments.positional()[0] != "vps") {
    return Complain("bench", "no bench '" + arguments.positional()[0] + "'; known: vps, physics, bus", kBadUsage);
  }
  contact::BenchOptions options;
  options.json = arguments.text("--json");
  options.plot = arguments.text("--plot");
  options.places = {arguments.text("--scenarios", "scenarios"), arguments.text("--meshes", "../shared/data/meshes")};
  options.only = arguments.text("--pair");
  RunPeers("oos_bench_peers",
           {options.json, options.plot, options.places.meshes, options.places.scenarios, options.only});
  return contact::BenchMain(options, {});
}

}  // namespace

Verb BenchVerb() {
  return {"bench",
          "times and errors of contact queries, of the dynamics or of the bus, charted against exact answers and other "
          "libraries",
          "vps|physics|bus",
          1,
          1,
          {{"--json", "FILE", "where all numbers go"},
           {"--plot", "DIR", "folder for the charts (SVG) and their tables (CSV)"},
           {"--meshes", "DIR", "public meshes; default ../shared/data/meshes"},
           {"--scenarios", "DIR", "folder of the scenarios; default scenarios"},
           {"--pair", "NAMES", "only these parts or studies, with commas; a wrong name lists all"}},
          Run,
          kDetails};
}

}  // namespace oos
