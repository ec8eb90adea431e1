#include "nodes/logic_node/procedure.hpp"

#include <algorithm>

#include "core/names.hpp"
#include "nodes/logic_node/scxml/analyse_chart.hpp"
#include "nodes/logic_node/scxml/load_chart.hpp"

namespace logic_node {

std::vector<std::string> ParameterNames(const scene::Scenario& scenario) {
  std::vector<std::string> names{"force_cap_N"};
  for (std::size_t pair = 0; pair < scenario.pairs.size(); ++pair) {
    names.push_back("pair." + scenario.PairName(pair) + ".active");
    names.push_back("pair." + scenario.PairName(pair) + ".stiffness_N_per_m");
  }
  for (const scene::Mechanism& mechanism : scenario.mechanisms) {
    for (const char* figure : scene::LiveFigures(mechanism)) names.push_back(mechanism.name + "." + figure);
  }
  for (const scene::Object& object : scenario.objects) {
    if (object.sheet) names.push_back("sheet." + object.name + ".active");
  }
  for (const scene::Parameter& parameter : scenario.parameters) names.push_back(parameter.name);
  return names;
}

tl::expected<scxml::Chart, std::vector<scene::Diagnostic>> LoadProcedure(const scene::Scenario& scenario,
                                                                         Signals* signals) {
  const std::vector<std::string> parameters = ParameterNames(scenario);
  std::vector<std::string> lamps;
  for (const scene::Object& object : scenario.objects) {
    if (object.is_lamp) lamps.push_back(object.name);
  }
  scxml::Vocabulary vocabulary;
  vocabulary.find_signal = [&](const std::string& name) { return signals->Find(name); };
  vocabulary.suggest_signal = [&](const std::string& name) { return signals->Suggest(name); };
  vocabulary.is_parameter = [&](const std::string& name) {
    return std::find(parameters.begin(), parameters.end(), name) != parameters.end();
  };
  vocabulary.suggest_parameter = [&](const std::string& name) {
    const std::string nearest = core::NearestName(name, parameters);
    return nearest.empty() ? std::string("see the list in scenarios/README.md, or add a <parameter> to the scenario")
                           : "did you mean '" + nearest + "'?";
  };
  vocabulary.find_lamp = [&](const std::string& name) -> std::optional<int> {
    const bool is_lamp = std::find(lamps.begin(), lamps.end(), name) != lamps.end();
    return is_lamp ? std::optional<int>(scenario.FindObject(name)) : std::nullopt;
  };
  vocabulary.suggest_lamp = [&](const std::string& name) { return core::SuggestName(name, lamps); };

  auto chart = scxml::LoadChart(scenario.procedure, vocabulary);
  if (!chart) return chart;
  std::vector<scene::Diagnostic> diagnostics = scxml::AnalyseChart(*chart);
  if (!diagnostics.empty()) return tl::unexpected(std::move(diagnostics));
  return chart;
}

std::vector<scene::Diagnostic> CheckProcedure(const scene::Scenario& scenario) {
  Signals signals(scenario);
  const auto chart = LoadProcedure(scenario, &signals);
  return chart ? std::vector<scene::Diagnostic>{} : chart.error();
}

}  // namespace logic_node
