#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "nodes/logic_node/scxml/chart.hpp"
#include "scene/diagnostic.hpp"

namespace logic_node::scxml {

constexpr const char* kScxmlNamespace = "http://www.w3.org/2005/07/scxml";
constexpr const char* kProcedureNamespace = "urn:vr-oos:procedure";

// Names of the scenario that a chart may use. An absent function knows no name.
struct Vocabulary {
  std::function<std::optional<Symbol>(const std::string& name)> find_signal;
  std::function<std::string(const std::string& name)> suggest_signal;
  std::function<bool(const std::string& name)> is_parameter;
  std::function<std::string(const std::string& name)> suggest_parameter;
  std::function<std::optional<int>(const std::string& object)> find_lamp;
  std::function<std::string(const std::string& object)> suggest_lamp;
};

// Reads the SCXML subset: scxml, state, parallel, initial, final, history (shallow), transition, onentry, onexit, log,
// raise, send, cancel, assign, if, elseif, else, datamodel, data, and vr:set, vr:lamp, vr:hint. Refuses everything else
// with its line, and unknown targets, names, parameters and lamps. Returns all errors.
tl::expected<Chart, std::vector<scene::Diagnostic>> LoadChart(const std::filesystem::path& file,
                                                              const Vocabulary& vocabulary);

}  // namespace logic_node::scxml
