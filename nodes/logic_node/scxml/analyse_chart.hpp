#pragma once

#include <vector>

#include "nodes/logic_node/scxml/chart.hpp"
#include "scene/diagnostic.hpp"

namespace logic_node::scxml {

// Id of the region whose child states are the steps of the report.
constexpr const char* kProcedureRegion = "procedure";

// Steps of a chart in document order: child states of the procedure region, without finals.
std::vector<int> FindSteps(const Chart& chart);

// Over-approximation of the states that a run can enter, one flag per state: assumes that every transition of a
// reachable state can be taken unless its condition is constantly false.
std::vector<char> FindReachable(const Chart& chart);

// Finds states that are never entered, a missing procedure region or final state, and steps that cannot be completed or
// from which no path leads to the final state.
std::vector<scene::Diagnostic> AnalyseChart(const Chart& chart);

}  // namespace logic_node::scxml
