#include "tools/oos/sweep/sweep_plan.hpp"

#include <libxml/parser.h>
#include <libxml/tree.h>

#include <charconv>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <sstream>

#include "scene/load_scenario.hpp"

namespace oos {
namespace {

constexpr int kMostValues = 10'000;
constexpr const char* kForm =
    "; an axis is NAME=LOW:HIGH:N or NAME=V,V,..., where NAME is ATTRIBUTE, ELEMENT.ATTRIBUTE or "
    "ELEMENT[NAME].ATTRIBUTE of the scenario file";

template <typename T>
bool Parse(const std::string& text, T* value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
  return error == std::errc() && end == text.data() + text.size();
}

std::vector<std::string> Split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, at);) parts.push_back(part);
  return parts;
}

struct FreeDocument {
  void operator()(xmlDoc* document) const { xmlFreeDoc(document); }
};

std::string AttributeOf(xmlNode* element, const std::string& name) {
  std::string value;
  if (xmlChar* text = xmlGetNoNsProp(element, reinterpret_cast<const xmlChar*>(name.c_str())); text != nullptr) {
    value = reinterpret_cast<const char*>(text);
    xmlFree(text);
  }
  return value;
}

void SetAttribute(xmlNode* element, const std::string& name, const std::string& value) {
  xmlSetProp(element, reinterpret_cast<const xmlChar*>(name.c_str()), reinterpret_cast<const xmlChar*>(value.c_str()));
}

void ForEachElement(xmlNode* node, const std::function<void(xmlNode*)>& visit) {
  for (; node != nullptr; node = node->next) {
    if (node->type != XML_ELEMENT_NODE) continue;
    visit(node);
    ForEachElement(node->children, visit);
  }
}

// Sets the attribute. One that the file leaves to its default is added only if the axis names the element.
int Set(xmlNode* root, const GridAxis& axis, const std::string& value) {
  int count = 0;
  ForEachElement(root, [&](xmlNode* element) {
    if (!axis.element.empty() && axis.element != reinterpret_cast<const char*>(element->name)) return;
    if (!axis.element_name.empty() && axis.element_name != AttributeOf(element, "name")) return;
    const bool is_there = xmlHasProp(element, reinterpret_cast<const xmlChar*>(axis.attribute.c_str())) != nullptr;
    if (!is_there && axis.element.empty()) return;
    SetAttribute(element, axis.attribute, value);
    ++count;
  });
  return count;
}

std::unique_ptr<xmlDoc, FreeDocument> ReadDocument(const std::filesystem::path& file) {
  return std::unique_ptr<xmlDoc, FreeDocument>(
      xmlReadFile(file.c_str(), nullptr, XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING));
}

core::Result<void> WriteDocument(xmlDoc* document, const std::filesystem::path& file) {
  if (xmlSaveFile(file.c_str(), document) >= 0) return {};
  return core::Fail(core::ErrorCode::kIo, "cannot write " + file.string() + "; is the folder writable?");
}

// Copies the files outside the scenario's folder, each into a folder of its own, so that equal names do not clash.
class ReferencedFiles {
 public:
  ReferencedFiles(std::filesystem::path from, std::filesystem::path to) : from_(std::move(from)), to_(std::move(to)) {}

  // All that the elements of `file` refer to; relative paths are relative to the scenario's folder.
  core::Result<void> CopyAll(const std::filesystem::path& file, xmlNode* root) {
    core::Result<void> result;
    ForEachElement(root, [&](xmlNode* element) {
      for (const char* attribute : {"mesh", "file", "links", "hand"}) {
        const std::string value = AttributeOf(element, attribute);
        if (value.empty() || !result) continue;
        const auto place = Copy(value);
        if (!place) {
          result = core::Fail(place.error().code, file.string() + ":" + std::to_string(xmlGetLineNo(element)) + ": " +
                                                      attribute + "=\"" + value + "\": " + place.error().detail);
          continue;
        }
        if (*place != value) SetAttribute(element, attribute, *place);
        if (attribute == std::string_view("hand")) result = CopyHand((from_ / value).lexically_normal(), *place);
        if (attribute == std::string_view("links")) result = CopyLinks((from_ / value).lexically_normal(), *place);
      }
    });
    return result;
  }

 private:
  // Its path in the copy.
  core::Result<std::string> Copy(const std::filesystem::path& value) {
    const std::filesystem::path source = (from_ / value).lexically_normal();
    const std::filesystem::path inside = source.lexically_relative(from_);
    if (*inside.begin() != "..") return inside.string();
    std::string& place = places_[source];
    if (!place.empty()) return place;
    if (source.extension() == ".gltf") {
      return core::Fail(core::ErrorCode::kUnsupported,
                        "a .gltf outside the scenario's folder cannot be copied, as parts of it are in other files; "
                        "save it as .glb");
    }
    std::error_code error;
    std::filesystem::path folder;
    // A scenario that is itself the copy of a sweep already has some of these folders.
    for (int number = 1; folder.empty() || std::filesystem::exists(to_ / folder, error); ++number) {
      folder = std::filesystem::path("from_elsewhere") / std::to_string(number);
    }
    std::filesystem::create_directories(to_ / folder, error);
    std::filesystem::copy_file(source, to_ / folder / source.filename(), error);
    if (error) {
      return core::Fail(core::ErrorCode::kIo, "cannot copy " + source.string() + " to " + (to_ / folder).string() +
                                                  ": " + error.message() + "; correct the path, or make the file");
    }
    return place = (folder / source.filename()).string();
  }

  // An arm's links are in a file that refers to further ones.
  core::Result<void> CopyLinks(const std::filesystem::path& links, const std::string& place) {
    const auto document = ReadDocument(links);
    if (!document) return core::Fail(core::ErrorCode::kIo, "cannot read " + links.string() + " as XML");
    if (auto copied = CopyAll(links, xmlDocGetRootElement(document.get())); !copied) return copied;
    return WriteDocument(document.get(), to_ / place);
  }

  // The meshes of a hand are named from where its file is.
  core::Result<void> CopyHand(const std::filesystem::path& hand, const std::string& place) {
    const auto document = ReadDocument(hand);
    if (!document) return core::Fail(core::ErrorCode::kIo, "cannot read " + hand.string() + " as XML");
    core::Result<void> result;
    ForEachElement(xmlDocGetRootElement(document.get()), [&](xmlNode* element) {
      const std::string mesh = AttributeOf(element, "mesh");
      if (mesh.empty() || !result) return;
      const auto copied = Copy(hand.parent_path() / mesh);
      if (!copied) {
        result = tl::unexpected(copied.error());
        return;
      }
      const std::filesystem::path folder = std::filesystem::path(place).parent_path();
      SetAttribute(element, "mesh",
                   std::filesystem::path(*copied).lexically_relative(folder.empty() ? "." : folder).string());
    });
    if (!result) return result;
    return WriteDocument(document.get(), to_ / place);
  }

  const std::filesystem::path from_, to_;
  std::map<std::filesystem::path, std::string> places_;  // in the copy, by where they were
};

}  // namespace

core::Result<GridAxis> ParseAxis(const std::string& text) {
  const auto fail = [&](const std::string& what) {
    return core::Fail(core::ErrorCode::kInvalidInput, "--grid " + text + ": " + what + kForm);
  };
  // The last '=': a name in brackets may contain others.
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0) return fail("has no '='");
  GridAxis axis;
  axis.name = text.substr(0, equals);
  const std::size_t bracket = axis.name.find('[');
  const std::size_t dot = axis.name.rfind('.');
  axis.attribute = dot == std::string::npos ? axis.name : axis.name.substr(dot + 1);
  if (dot != std::string::npos) axis.element = axis.name.substr(0, std::min(dot, bracket));
  if (bracket != std::string::npos) {
    const std::size_t end = axis.name.find(']', bracket);
    if (end == std::string::npos || end + 1 != dot) return fail("the bracket does not end before the attribute");
    axis.element_name = axis.name.substr(bracket + 1, end - bracket - 1);
  }
  if (axis.attribute.empty()) return fail("names no attribute");
  const std::string range = text.substr(equals + 1);
  const std::vector<std::string> ends = Split(range, ':');
  if (ends.size() == 1) {
    axis.values = Split(range, ',');
    if (axis.values.empty()) return fail("has no values");
    return axis;
  }
  double low = 0.0, high = 0.0;
  int count = 0;
  if (ends.size() != 3 || !Parse(ends[0], &low) || !Parse(ends[1], &high) || !Parse(ends[2], &count)) {
    return fail("'" + range + "' is no range");
  }
  if (count < 2 || count > kMostValues) return fail("a range has 2 to 10000 values");
  for (int i = 0; i < count; ++i) {
    char value[32];
    std::snprintf(value, sizeof value, "%.10g", low + (high - low) * i / (count - 1));
    axis.values.emplace_back(value);
  }
  return axis;
}

std::vector<SweepRun> PlanRuns(const std::vector<GridAxis>& axes, unsigned num_seeds) {
  std::vector<SweepRun> runs;
  std::vector<std::size_t> at(axes.size(), 0);
  for (bool is_done = false; !is_done;) {
    for (unsigned seed = 1; seed <= num_seeds; ++seed) {
      SweepRun run;
      char name[16];
      std::snprintf(name, sizeof name, "%05zu", runs.size() + 1);
      run.name = name;
      run.seed = seed;
      for (std::size_t a = 0; a < axes.size(); ++a) run.values.push_back(axes[a].values[at[a]]);
      runs.push_back(std::move(run));
    }
    is_done = true;
    for (std::size_t a = axes.size(); a-- > 0 && is_done;) {
      at[a] = (at[a] + 1) % axes[a].values.size();
      is_done = at[a] == 0;
    }
  }
  return runs;
}

core::Result<void> WriteScenarioCopy(const std::filesystem::path& scenario_file, const std::vector<GridAxis>& axes,
                                     const std::vector<std::string>& values, const std::filesystem::path& folder) {
  const std::filesystem::path from = std::filesystem::absolute(scenario_file).lexically_normal().parent_path();
  std::error_code error;
  std::filesystem::create_directories(folder.parent_path(), error);
  std::filesystem::copy(from, folder, std::filesystem::copy_options::recursive, error);
  if (error) {
    return core::Fail(core::ErrorCode::kIo, "cannot copy " + from.string() + " to " + folder.string() + ": " +
                                                error.message() + "; is there room, is the folder writable?");
  }
  const auto document = ReadDocument(scenario_file);
  if (!document) return core::Fail(core::ErrorCode::kIo, "cannot read " + scenario_file.string() + " as XML");
  xmlNode* const root = xmlDocGetRootElement(document.get());
  for (std::size_t a = 0; a < axes.size(); ++a) {
    if (Set(root, axes[a], values[a]) == 0) {
      return core::Fail(core::ErrorCode::kNotFound,
                        "--grid " + axes[a].name + ": nothing in " + scenario_file.string() + " has it" + kForm);
    }
  }
  if (auto copied = ReferencedFiles(from, folder).CopyAll(scenario_file, root); !copied) return copied;
  const std::filesystem::path file = folder / scenario_file.filename();
  if (auto written = WriteDocument(document.get(), file); !written) return written;
  if (const auto loaded = scene::LoadScenario(file); !loaded) {
    return core::Fail(core::ErrorCode::kInvalidInput, scene::Format(loaded.error().front()));
  }
  return {};
}

}  // namespace oos
