#include <cstdio>

#include "tools/oos/latency_table.hpp"
#include "tools/oos/verb.hpp"

namespace oos {
namespace {

constexpr double kMaxDisagreement = 0.05;

void PrintRow(const std::string& name, const Distribution& d) {
  std::printf("  %-36s %8.3f %8.3f %8.3f %8.3f %8.3f %8.3f %8zu\n", name.c_str(), d.mean_ms, d.p50_ms, d.p90_ms,
              d.p99_ms, d.p999_ms, d.max_ms, d.n);
}

int Run(const Arguments& arguments) {
  const auto rows = ReadLatencyRows(std::filesystem::path(arguments.positional()[0]) / "latency.csv");
  if (!rows) return Complain("latency", rows.error().detail, kBadUsage);
  int status = kHolds;
  bool is_checked = false;
  for (const ChainTable& table : Tabulate(*rows)) {
    std::printf("%s, ms\n  %-36s %8s %8s %8s %8s %8s %8s %8s\n", table.chain.c_str(), "", "mean", "p50", "p90", "p99",
                "p99.9", "max", "n");
    for (const Hop& hop : table.hops) PrintRow(hop.name, hop.ms);
    PrintRow("total by stamps", table.total);
    if (table.echo.n > 0) {
      PrintRow("total by the bridge's echo log", table.echo);
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
  return {"latency", "the latency chain of a run, hop by hop, checked against the bridge's own log (at most 5 % apart)",
          "RUN",     1,
          1,         {},
          Run};
}

}  // namespace oos
