#include "tools/failures/testing/documented_rows.hpp"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <sstream>

namespace failures {
namespace {

// One line's cells; a quoted cell may contain commas, and a doubled quote is one.
std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && is_quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cells.back() += line[++i];
    } else if (line[i] == '"') {
      is_quoted = !is_quoted;
    } else if (line[i] == ',' && !is_quoted) {
      cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
  }
  return cells;
}

}  // namespace

Verdicts ParseVerdicts(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> columns = Cells(line);
  const auto column = [&columns](const char* name) {
    return static_cast<std::size_t>(std::find(columns.begin(), columns.end(), name) - columns.begin());
  };
  Verdicts verdicts;
  while (std::getline(lines, line)) {
    const std::vector<std::string> cells = Cells(line);
    const std::string name =
        cells.at(column("id")) + ", " + cells.at(column("set-up")) + ": " + cells.at(column("observable"));
    verdicts[name] = cells.at(column("met"));
  }
  return verdicts;
}

Verdicts ReadVerdicts(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return ParseVerdicts(text.str());
}

Verdicts DocumentedVerdicts(const std::filesystem::path& root) {
  return ReadVerdicts(root / "docs/performance/stability/rows.csv");
}

std::vector<std::string> Contradictions(const Verdicts& measured, const Verdicts& documented) {
  std::vector<std::string> lines;
  for (const auto& [row, verdict] : measured) {
    const auto said = documented.find(row);
    if (said == documented.end()) {
      lines.push_back(row + ": met: " + verdict + "; docs/performance/stability.md does not have it");
    } else if (said->second != verdict) {
      lines.push_back(row + ": met: " + verdict + "; docs/performance/stability.md says " + said->second);
    }
  }
  return lines;
}

}  // namespace failures
