#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scene/diagnostic.hpp"
#include "scene/scenario.hpp"
#include "scene/xml.hpp"

namespace scene {

// A <pair> element as written: names are resolved when pairs are generated.
struct PairElement {
  std::string a;
  std::string b;
  bool is_collide = true;
  Pair figures;  // stiffness and so on; object indices not set
};

// Steps of LoadScenario, one file each. All append to `diagnostics` and go on.

// Puts the objects and hinges of every <arm> behind what is in the file; they count as written in the arm's line.
void ExpandArms(const std::filesystem::path& file, XmlElement* root, std::vector<Diagnostic>* diagnostics);

// XML tree -> Scenario without pairs. Values that break the rules of schema.hpp keep their defaults here.
Scenario ReadScenario(const XmlElement& root, const std::filesystem::path& file, std::vector<PairElement>* pairs,
                      std::vector<Diagnostic>* diagnostics);

// A <sheet> of the object given.
Sheet ReadSheet(const XmlElement& element, const Object& object, const std::filesystem::path& file,
                std::vector<Diagnostic>* diagnostics);

// Mechanisms in file order, whatever their kind: the order is the id on the bus. Adds to `scenario`, whose objects must
// have their poses; a toggle switch's lever is turned to its detent.
void ReadMechanisms(const XmlElement& root, const std::filesystem::path& file, Scenario* scenario,
                    std::vector<Diagnostic>* diagnostics);

// What holds between elements: names, ownership, masses, hands, mechanisms, files.
void CheckScenario(const Scenario& scenario, std::vector<Diagnostic>* diagnostics);

// Contact pairs from groups, changed by the <pair> elements; see scenarios/README.md for the rule.
void GeneratePairs(const std::vector<PairElement>& elements, Scenario* scenario, std::vector<Diagnostic>* diagnostics);

}  // namespace scene
