#pragma once

#include <tl/expected.hpp>
#include <vector>

#include "nodes/logic_node/scxml/chart.hpp"
#include "nodes/logic_node/signals.hpp"
#include "scene/diagnostic.hpp"
#include "scene/scenario.hpp"

namespace logic_node {

// Every parameter that can be changed while the scenario runs, see scenarios/README.md.
std::vector<std::string> ParameterNames(const scene::Scenario& scenario);

// The scenario's procedure as a checked chart; its signals get slots in `signals`.
tl::expected<scxml::Chart, std::vector<scene::Diagnostic>> LoadProcedure(const scene::Scenario& scenario,
                                                                         Signals* signals);

// All that is wrong with the scenario's procedure; empty: nothing. Used by `oos check`.
std::vector<scene::Diagnostic> CheckProcedure(const scene::Scenario& scenario);

}  // namespace logic_node
