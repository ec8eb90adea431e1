#pragma once

#include <string_view>

#include "core/messages/logic.hpp"

namespace bus {

using core::Figure;
using core::Figures;

// Null: no figure of that name.
inline const double* FindFigure(const Figures& figures, std::string_view name) {
  for (const Figure& figure : figures.items) {
    if (figure.name == name) return &figure.value;
  }
  return nullptr;
}

}  // namespace bus
