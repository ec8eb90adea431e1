#include "view/choices.hpp"

#include <algorithm>
#include <sstream>

#include "core/names.hpp"

namespace view {
namespace {

constexpr std::string_view kOverlayPrefix = "overlay.";
constexpr std::string_view kSelectPrefix = "select.";
constexpr std::string_view kStereoPrefix = "stereo.";

// -1: none.
int FindName(std::string_view name, const std::vector<std::string>& objects) {
  const auto found = std::find(objects.begin(), objects.end(), name);
  return found == objects.end() ? -1 : static_cast<int>(found - objects.begin());
}

bool Select(int object, bool is_on, Choices* choices) {
  if (object < 0) return false;
  if (is_on) {
    choices->selected = object;
  } else if (choices->selected == object) {
    choices->selected = -1;
  }
  return true;
}

bool ChooseStereo(std::string_view name, bool is_on, Choices* choices) {
  const std::optional<Stereo> mode = FindStereo(name);
  if (!mode || mode == Stereo::kNone) return false;
  if (is_on) {
    choices->stereo = *mode;
  } else if (choices->stereo == *mode) {
    choices->stereo = Stereo::kNone;
  }
  return true;
}

}  // namespace

OverlaySet DefaultOverlays() {
  OverlaySet set;
  for (const OverlayInfo& info : kOverlays) set[IndexOf(info.overlay)] = info.is_on_at_start;
  return set;
}

std::optional<Overlay> FindOverlay(std::string_view name) {
  for (const OverlayInfo& info : kOverlays) {
    if (info.name == name) return info.overlay;
  }
  return std::nullopt;
}

std::optional<Overlay> FindOverlayOfKey(char key) {
  for (const OverlayInfo& info : kOverlays) {
    if (info.key == key) return info.overlay;
  }
  return std::nullopt;
}

std::vector<std::string> ChoiceNames(const std::vector<std::string>& objects) {
  std::vector<std::string> names;
  for (const OverlayInfo& info : kOverlays) names.push_back(std::string(kOverlayPrefix) + info.name);
  for (const StereoInfo& info : kStereoModes) names.push_back(std::string(kStereoPrefix) + info.name);
  for (const PartChoice& choice : kPartChoices) {
    for (const std::string& object : objects) names.push_back(std::string(choice.name) + "." + object);
  }
  for (const std::string& object : objects) names.push_back(std::string(kSelectPrefix) + object);
  return names;
}

bool SetChoice(const std::string& name, bool is_on, const std::vector<std::string>& objects, Choices* choices) {
  if (name.starts_with(kOverlayPrefix)) {
    const auto overlay = FindOverlay(std::string_view(name).substr(kOverlayPrefix.size()));
    if (overlay) choices->overlays[IndexOf(*overlay)] = is_on;
    return overlay.has_value();
  }
  if (name.starts_with(kStereoPrefix)) {
    return ChooseStereo(std::string_view(name).substr(kStereoPrefix.size()), is_on, choices);
  }
  if (name.starts_with(kSelectPrefix)) {
    return Select(FindName(std::string_view(name).substr(kSelectPrefix.size()), objects), is_on, choices);
  }
  for (const PartChoice& choice : kPartChoices) {
    const std::string prefix = std::string(choice.name) + ".";
    if (!name.starts_with(prefix)) continue;
    const int object = FindName(std::string_view(name).substr(prefix.size()), objects);
    if (object < 0) return false;
    choices->objects.resize(std::max(choices->objects.size(), objects.size()));
    choices->objects[static_cast<std::size_t>(object)].*choice.flag = is_on;
    return true;
  }
  return false;
}

core::Result<Choices> ReadChoices(const std::string& list, const std::vector<std::string>& objects) {
  std::string words = list;
  std::replace(words.begin(), words.end(), ',', ' ');
  std::istringstream in(words);
  Choices choices;
  for (std::string word; in >> word;) {
    const bool is_on = !word.starts_with("no_");
    const std::string name = is_on ? word : word.substr(3);
    const bool is_known = SetChoice(name, is_on, objects, &choices) ||
                          SetChoice(std::string(kOverlayPrefix) + name, is_on, objects, &choices);
    if (is_known) continue;
    std::vector<std::string> known = ChoiceNames(objects);
    for (std::string& full : known) {
      if (full.starts_with(kOverlayPrefix)) full = full.substr(kOverlayPrefix.size());
    }
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "nothing called '" + name + "' can be shown; " + core::SuggestName(name, known));
  }
  return choices;
}

}  // namespace view
