#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/diagnostic.hpp"
#include "scene/scenario.hpp"
#include "scene/xml.hpp"

namespace scene {

// A <pair> element with its names as written; GeneratePairs resolves them.
struct PairElement {
  std::string a;
  std::string b;
  bool is_collide = true;
  Pair figures;  // stiffness and so on; the object indices are not set, nor are accuracy and budget
  std::optional<double> accuracy, budget_us;  // none: the scenario's
};

// Steps of LoadScenario, one file each. Each appends errors to `diagnostics` and continues.

// Appends the objects and hinges of every <arm> to the root's children, with the line of the <arm>.
void ExpandArms(const std::filesystem::path& file, XmlElement* root, std::vector<Diagnostic>* diagnostics);

// The same for every <fingers>: the links of a hand's fingers and their hinges.
void ExpandFingers(const std::filesystem::path& file, XmlElement* root, std::vector<Diagnostic>* diagnostics);

// Builds the Scenario, without its pairs, from the XML tree. Values that violate the rules of schema.hpp keep their
// defaults.
Scenario ReadScenario(const XmlElement& root, const std::filesystem::path& file, std::vector<PairElement>* pairs,
                      std::vector<Diagnostic>* diagnostics);

// Reads a <sheet> element of the given object.
Sheet ReadSheet(const XmlElement& element, const Object& object, const std::filesystem::path& file,
                std::vector<Diagnostic>* diagnostics);

// The material of a <visual>.
Material ReadMaterial(const XmlElement& visual);

// Adds <scenery> and <shown_arm>, what is seen only, after the devices.
void ReadScenery(const XmlElement& root, const std::filesystem::path& file, Scenario* scenario,
                 std::vector<Diagnostic>* diagnostics);

// Adds the mechanisms to `scenario` in file order (the index is the id on the bus), after all objects have their poses.
// Moves a hinge's child to its start angle.
void ReadMechanisms(const XmlElement& root, const std::filesystem::path& file, Scenario* scenario,
                    std::vector<Diagnostic>* diagnostics);

// Checks the rules between elements: names, ownership, masses, hands, mechanisms, files.
void CheckScenario(const Scenario& scenario, std::vector<Diagnostic>* diagnostics);

// Adds the contact pairs that follow from the groups, modified by the <pair> elements; rule in scenarios/README.md.
void GeneratePairs(const std::vector<PairElement>& elements, Scenario* scenario, std::vector<Diagnostic>* diagnostics);

}  // namespace scene
