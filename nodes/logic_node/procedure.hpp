#pragma once

#include <tl/expected.hpp>
#include <vector>

#include "nodes/logic_node/scxml/chart.hpp"
#include "nodes/logic_node/signals.hpp"
#include "scene/diagnostic.hpp"
#include "scene/scenario.hpp"

namespace logic_node {

// Names of all parameters that can be changed at run time, see scenarios/README.md.
std::vector<std::string> ParameterNames(const scene::Scenario& scenario);

// Loads the scenario's procedure as a checked chart; its signals get slots in `signals`.
tl::expected<scxml::Chart, std::vector<scene::Diagnostic>> LoadProcedure(const scene::Scenario& scenario,
                                                                         Signals* signals);

// All errors of the scenario's procedure, for `oos check`.
std::vector<scene::Diagnostic> CheckProcedure(const scene::Scenario& scenario);

}  // namespace logic_node
