#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/transport/studies.hpp"

namespace transport {

// Measured values by contender, one for each round; NaN if there is none.
using ByRound = std::map<std::string, std::vector<double>>;

// Adds the cost of encryption to the report's table `encryption` and prints it, for every contender measured both ways
// (the other one's name ends in ", not encrypted"). The differences are taken round by round; a difference within its
// scatter counts as none.
void AddCostOfEncryption(const std::string& what, const std::string& unit, const ByRound& rounds, Report* report);

}  // namespace transport
