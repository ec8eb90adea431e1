#pragma once

#include <vector>

#include "nodes/logic_node/scxml/chart.hpp"
#include "scene/diagnostic.hpp"

namespace logic_node::scxml {

// The region whose child states are the steps of the report.
constexpr const char* kProcedureRegion = "procedure";

// Steps of a chart in document order: child states of the procedure region, without finals.
std::vector<int> FindSteps(const Chart& chart);

// States that some run can enter, over-approximated: every transition of a state that can be entered may be taken,
// unless its condition is constant and false.
std::vector<char> FindReachable(const Chart& chart);

// What a chart says that cannot have been meant: states that are never entered, a missing procedure region or final, a
// step that cannot be completed, or that no way leads out of to
// the final.
std::vector<scene::Diagnostic> AnalyseChart(const Chart& chart);

}  // namespace logic_node::scxml
