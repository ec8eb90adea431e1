#pragma once

#include <cstddef>
#include <string>

#include "core/messages/logic.hpp"

namespace core {

// As many characters as the bus sends of an event's or a parameter's texts.
constexpr std::size_t kMaxTextChars = 255;

// Makes room, so that a real-time step can write into the texts without allocating.
inline void ReserveTexts(Event* event) {
  for (std::string* text : {&event->source, &event->name, &event->detail}) text->reserve(kMaxTextChars);
}
inline void ReserveTexts(ParameterChange* change) {
  change->name.reserve(kMaxTextChars);
}

}  // namespace core
