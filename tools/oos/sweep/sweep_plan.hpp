#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace oos {

// One axis of a sweep's grid: an attribute of the scenario file and its values.
struct GridAxis {
  std::string name;          // as given: ATTRIBUTE, ELEMENT.ATTRIBUTE or ELEMENT[NAME].ATTRIBUTE
  std::string element;       // empty: any
  std::string element_name;  // its name="..."; empty: any
  std::string attribute;
  std::vector<std::string> values;
};

// Parses "NAME=LOW:HIGH:N", N values at equal steps with both ends, or "NAME=V,V,...", a list of values.
core::Result<GridAxis> ParseAxis(const std::string& text);

// One run: a value per axis and a seed.
struct SweepRun {
  std::string name;  // of its folder
  std::vector<std::string> values;
  std::uint64_t seed = 1;
};

// Every point of the grid with seeds 1 .. num_seeds, seeds next to each other.
std::vector<SweepRun> PlanRuns(const std::vector<GridAxis>& axes, unsigned num_seeds);

// Writes a copy of the scenario with these values into `folder`, with all files that it refers to elsewhere. `folder`
// must not be inside the scenario's own. Fails if an axis matches no attribute, if a file cannot be copied, or if the
// scenario cannot be loaded with the values.
core::Result<void> WriteScenarioCopy(const std::filesystem::path& scenario_file, const std::vector<GridAxis>& axes,
                                     const std::vector<std::string>& values, const std::filesystem::path& folder);

}  // namespace oos
