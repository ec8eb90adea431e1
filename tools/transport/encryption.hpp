#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/transport/studies.hpp"

namespace transport {

// What was measured of each contender, a value a round; NaN: nothing.
using ByRound = std::map<std::string, std::vector<double>>;

// For every contender that has a twin ", not encrypted": a row in the report's table `encryption`, and a line to
// stdout, of what encryption costs, round by round. It counts only beyond its scatter.
void AddCostOfEncryption(const std::string& what, const std::string& unit, const ByRound& rounds, Report* report);

}  // namespace transport
