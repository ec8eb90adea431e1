#pragma once

#include <string>
#include <vector>

namespace bus {

// figures/<node> (STATE): named numbers that a node shows to `oos top` and to the run's report, a few times a second.
struct Figure {
  std::string name;  // with its unit, e.g. "step_p50_us"
  double value = 0.0;
};

struct Figures {
  std::vector<Figure> items;

  [[nodiscard]] const double* Find(const std::string& name) const {
    for (const Figure& figure : items) {
      if (figure.name == name) return &figure.value;
    }
    return nullptr;
  }
};

}  // namespace bus
