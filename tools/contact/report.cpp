#include "tools/contact/report.hpp"

#include <cstdio>

namespace contact {

const char* ToText(Verdict verdict) {
  switch (verdict) {
    case Verdict::kMet:
      return "yes";
    case Verdict::kPartly:
      return "partly";
    case Verdict::kMissed:
      return "no";
    default:
      return "not measured";
  }
}

Table GoalTable(const std::vector<Goal>& goals) {
  Table table{"goals", {"what", "wanted", "measured", "met"}, {}};
  for (const Goal& g : goals) table.Add({g.what, g.wanted, g.measured, ToText(g.verdict)});
  return table;
}

void PrintGoals(const std::vector<Goal>& goals) {
  std::printf("\n%-74s %-22s %-58s %s\n", "what", "wanted", "measured", "met");
  for (const Goal& g : goals) {
    std::printf("%-74s %-22s %-58s %s\n", g.what.c_str(), g.wanted.c_str(), g.measured.c_str(), ToText(g.verdict));
  }
}

}  // namespace contact
