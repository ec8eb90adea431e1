#include "tools/contact/report.hpp"

#include <cstdio>
#include <fstream>

#include "vps/walk/field_walk.hpp"

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

std::string MachineText() {
  std::ifstream stream("/proc/cpuinfo");
  std::string line;
  std::string processor = "unknown processor";
  while (std::getline(stream, line)) {
    if (line.rfind("model name", 0) == 0) {
      processor = line.substr(line.find(':') + 2);
      break;
    }
  }
  const vps::InstructionSet set = vps::BestInstructionSet();
  const char* const name = set == vps::InstructionSet::kAvx512 ? "AVX-512"
                           : set == vps::InstructionSet::kAvx2 ? "AVX2"
                                                               : "portable";
  return processor + ", one core; GCC " __VERSION__ "; walk: " + name;
}

std::string GoalPage(const std::vector<Goal>& goals) {
  std::string page = "# Goals of contact queries, measured\n\nWritten by `oos bench vps`. " + MachineText() +
                     ".\n\n| what | wanted | measured | met |\n|---|---|---|---|\n";
  for (const Goal& g : goals) {
    page += "| " + g.what + " | " + g.wanted + " | " + g.measured + " | " + ToText(g.verdict) + " |\n";
  }
  return page;
}

void PrintGoals(const std::vector<Goal>& goals) {
  std::printf("\n%-74s %-22s %-58s %s\n", "what", "wanted", "measured", "met");
  for (const Goal& g : goals) {
    std::printf("%-74s %-22s %-58s %s\n", g.what.c_str(), g.wanted.c_str(), g.measured.c_str(), ToText(g.verdict));
  }
}

}  // namespace contact
