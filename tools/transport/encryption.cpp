#include "tools/transport/encryption.hpp"

#include <algorithm>
#include <cstdio>

#include "tools/transport/scatter.hpp"

namespace transport {
namespace {

constexpr const char* kName = "encryption";

Table& TableOf(Report* report) {
  const auto found = std::find_if(report->tables.begin(), report->tables.end(),
                                  [](const Table& table) { return table.name == kName; });
  if (found != report->tables.end()) return *found;
  return report->tables.emplace_back(
      Table{kName,
            {"what", "unit", "rounds", "encrypted", "not_encrypted", "difference", "low", "high", "is_beyond_scatter"},
            {}});
}

}  // namespace

void AddCostOfEncryption(const std::string& what, const std::string& unit, const ByRound& rounds, Report* report) {
  for (const auto& [name, sealed] : rounds) {
    const auto twin = rounds.find(name + ", not encrypted");
    if (twin == rounds.end()) continue;
    const Scatter difference = ScatterOfDifference(sealed, twin->second);
    TableOf(report).Add({name + ": " + what, unit, std::to_string(sealed.size()), Cell(ScatterOf(sealed).median),
                         Cell(ScatterOf(twin->second).median), Cell(difference.median), Cell(difference.low),
                         Cell(difference.high), difference.excludes_zero() ? "yes" : "no"});
    std::printf("what encryption adds to %s of %s: %s\n", what.c_str(), name.c_str(),
                DifferenceText(difference, unit).c_str());
  }
}

}  // namespace transport
