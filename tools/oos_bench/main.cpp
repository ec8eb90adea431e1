// The studies behind `oos bench`: the contact engine, the dynamics, the bus and the stability of what the
// hand feels, measured and charted.

#include <unistd.h>

#include <string>
#include <utility>
#include <vector>

#include "tools/contact/bench.hpp"
#include "tools/dynamics/bench.hpp"
#include "tools/failures/bench.hpp"
#include "tools/oos/attach/places.hpp"
#include "tools/oos/bench/verbs.hpp"
#include "tools/process/spawn.hpp"
#ifdef VR_OOS_RAYS
#include "tools/rays/bench.hpp"
#endif
#include "tools/transport/bench.hpp"

namespace {

// Runs in place of this program if it stands beside it; else returns.
void RunPeers(const char* name, std::vector<std::string> words) {
  process::Command peers;
  peers.name = name;
  peers.program = oos::ProgramFolder() / name;
  if (access(peers.program.c_str(), X_OK) != 0) return;
  peers.arguments = std::move(words);
  oos::Complain("bench", process::Replace(peers).value().detail + "; going on without it", oos::kBadUsage);
}

bench::BenchOptions OptionsOf(const oos::Arguments& arguments) {
  return {arguments.text("--json"), arguments.text("--plot"), arguments.text("--pair")};
}

int RunPhysics(const oos::Arguments& arguments) {
  const bench::BenchOptions options = OptionsOf(arguments);
  RunPeers("oos_bench_dynamics_peers", {options.json, options.plot, options.only});
  return dynamics::BenchMain(options, {});
}

int RunBus(const oos::Arguments& arguments) {
  const bench::BenchOptions options = OptionsOf(arguments);
  RunPeers("oos_bench_transport_peers", {options.json, options.plot, options.only});
  return transport::BenchMain(options, {});
}

int RunStability(const oos::Arguments& arguments) {
  const bench::BenchOptions options = OptionsOf(arguments);
  RunPeers("oos_bench_failures_peers", {options.json, options.plot, options.only});
  return failures::BenchMain(options, {});
}

int RunRays([[maybe_unused]] const oos::Arguments& arguments) {
#ifdef VR_OOS_RAYS
  return rays::BenchMain(OptionsOf(arguments), oos::ProgramFolder(), arguments.text("--scenarios", "scenarios"));
#else
  return oos::Complain("bench", "this build has no ray tracer: configure it with -DVR_OOS_RAYS=ON", oos::kBadUsage);
#endif
}

int RunStudies(const oos::Arguments& arguments) {
  if (arguments.positional()[0] == "physics") return RunPhysics(arguments);
  if (arguments.positional()[0] == "bus") return RunBus(arguments);
  if (arguments.positional()[0] == "stability") return RunStability(arguments);
  if (arguments.positional()[0] == "rays") return RunRays(arguments);
  if (arguments.positional()[0] != "vps") {
    return oos::Complain("bench",
                         "no bench '" + arguments.positional()[0] + "'; known: vps, physics, bus, stability, rays",
                         oos::kBadUsage);
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

int main(int argc, char** argv) {
  oos::Verb verb = oos::BenchVerb();
  verb.run = RunStudies;
  std::vector<std::string> words = {std::string(verb.name)};
  words.insert(words.end(), argv + 1, argv + argc);
  return oos::RunVerbs({verb}, words);
}
