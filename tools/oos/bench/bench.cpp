#include "tools/oos/attach/places.hpp"
#include "tools/oos/bench/verbs.hpp"
#include "tools/process/spawn.hpp"

namespace oos {
namespace {

constexpr std::string_view kDetails =
    R"(vps: every query figure of the contact engine, on one core, with the goals that it must hold. For every pair of
parts, hands' motions of consecutive poses and independent poses: times (median, 99th percentile, worst; contenders take turns) and
errors of force direction, magnitude, torque and depth against the exact answer. Then scaling with points and with
pairs, the walk beside a flat scan and the machine's random reads, instruction sets, the field's accuracy, the ripple of
a slide, the time of cooking, and the errors on generated parts: those that constants may be chosen on, and others
(heldout), with what an accuracy costs there and in the shipped scenes (scenes). Tables go to stdout, all of it to the JSON file, and a CSV beside each SVG chart to the plot
folder. Parts whose meshes are missing are named and skipped. FCL, Bullet and OpenVDB take part when `oos_bench_peers` stands beside this program: `./dev bench`
builds it.

physics: the dynamics beside closed forms and Bullet: rotation, rebound under delay, reduction of contacts, mass ratio,
a peg that jams, sheets. MuJoCo takes part when `oos_bench_dynamics_peers` stands beside this program.

bus: one hop by transport and size, classes of topics, the age of the newest sample while packets are lost between two network
namespaces (root), throughput, processor time and blocks: the bus, encrypted and not, beside raw UDP, raw ZeroMQ and shared memory. LCM
takes part when `oos_bench_transport_peers` stands beside this program.

stability: the failure tests F1 to F23 of haptic rendering (thin parts, force steps, edges, delay, energy, impact, friction, rest, pegs,
overload), each with its bound and what every method does, by the nodes' own steps on a virtual clock. Takes some minutes.
Bullet takes part, and MuJoCo when `oos_bench_failures_peers` stands beside this program.

rays: how busy 1 to 16 emulated workers are with the costs of a real run, and the frames of 1280x720 that one and two
workers trace on this machine, which should be at rest.)";

// The studies and their charts are a program of their own, so that simulations are built and run without them.
int RunBench(const Arguments& arguments) {
  process::Command studies;
  studies.name = "oos_bench";
  studies.program = ProgramFolder() / "oos_bench";
  for (const Option& option : BenchVerb().options) {
    for (const std::string& value : arguments.texts(option.name)) {
      studies.arguments.insert(studies.arguments.end(), {std::string(option.name), value});
    }
  }
  studies.arguments.insert(studies.arguments.end(), arguments.positional().begin(), arguments.positional().end());
  return Complain("bench",
                  process::Replace(studies).value().detail + ": cmake --build build/release --target oos_bench",
                  kBadUsage);
}

}  // namespace

Verb BenchVerb() {
  return {"bench",
          "times and errors of contact queries, of the dynamics or of the bus, charted against exact answers and other "
          "libraries; the failure tests of stability",
          "vps|physics|bus|stability|rays",
          1,
          1,
          {{"--json", "FILE", "file for all numbers"},
           {"--plot", "DIR", "folder for the charts (SVG) and their tables (CSV)"},
           {"--meshes", "DIR", "public meshes; default ../shared/data/meshes"},
           {"--scenarios", "DIR", "folder of the scenarios; default scenarios"},
           {"--pair", "NAMES", "only these parts or studies, separated by commas; an unknown name lists them all"}},
          RunBench,
          kDetails};
}

}  // namespace oos
