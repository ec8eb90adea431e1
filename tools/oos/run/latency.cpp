#include <cstdio>

#include "tools/oos/run/latency/hop_bounds.hpp"
#include "tools/oos/run/latency/latency_table.hpp"
#include "tools/oos/run/verbs.hpp"

namespace oos {
namespace {

constexpr double kMaxDisagreement = 0.05;

// Times of two clocks without a bound mean nothing and are not printed.
void PrintRow(const std::string& name, const Distribution& d, std::optional<std::int64_t> bound_ns) {
  if (!bound_ns) {
    std::printf("  %-36s the clocks were not compared\n", name.c_str());
    return;
  }
  std::printf("  %-36s %8.3f %8.3f %8.3f %8.3f %8.3f %8.3f %8.3f %8zu\n", name.c_str(), d.mean_ms,
              1e-6 * static_cast<double>(*bound_ns), d.p50_ms, d.p90_ms, d.p99_ms, d.p999_ms, d.max_ms, d.n);
}

int RunLatency(const Arguments& arguments) {
  const auto rows = ReadLatencyRows(std::filesystem::path(arguments.positional()[0]) / "latency.csv");
  if (!rows) return Complain("latency", rows.error().detail, kBadUsage);
  const HopBounds bounds = HopBounds::Read(arguments.positional()[0]);
  std::printf("%s; +-: within that the clocks of a hop were compared\n",
              bounds.is_one_machine() ? "one machine, one clock" : "several machines");
  int status = kHolds;
  bool is_checked = false;
  for (const ChainTable& table : Tabulate(*rows)) {
    std::printf("%s, ms\n  %-36s %8s %8s %8s %8s %8s %8s %8s %8s\n", table.chain.c_str(), "", "mean", "+-", "p50",
                "p90", "p99", "p99.9", "max", "n");
    for (const Hop& hop : table.hops) PrintRow(hop.name, hop.ms, bounds.Between(hop.from, hop.to));
    PrintRow("total by stamps", table.total, bounds.Along(table.route));
    if (table.echo.n > 0) {
      PrintRow("total by the bridge's echo log", table.echo, 0);  // of its own clock alone
      const bool is_good = table.disagreement() <= kMaxDisagreement;
      std::printf("  %s: stamps and echo log are %.2f %% apart\n", is_good ? "OK" : "FAIL",
                  100.0 * table.disagreement());
      if (!is_good) status = kDoesNotHold;
      is_checked = true;
    }
  }
  if (!is_checked)
    return Complain("latency", "no trace came back to the bridge: nothing could be checked", kDoesNotHold);
  return status;
}

}  // namespace

Verb LatencyVerb() {
  return {"latency",
          "the latency chain of a run, hop by hop with clock bounds, checked against the bridge's own log (at most 5 % "
          "apart)",
          "RUN",
          1,
          1,
          {},
          RunLatency};
}

}  // namespace oos
