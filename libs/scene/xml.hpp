#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "scene/diagnostic.hpp"

namespace scene {

// A read-only XML tree with the line of every element and attribute, for diagnostics.

struct XmlAttribute {
  std::string name_space;  // URI; empty: none
  std::string name;        // without prefix
  std::string value;
  int line = 0;
};

struct XmlElement {
  std::string name_space;
  std::string name;
  std::vector<XmlAttribute> attributes;
  std::vector<XmlElement> children;  // elements only, in document order
  std::string text;                  // character data directly inside, trimmed
  int line = 0;                      // of the start tag's '<'

  [[nodiscard]] const XmlAttribute* Find(std::string_view attribute, std::string_view uri = {}) const;
  // Value of an attribute without namespace; `fallback` when absent.
  [[nodiscard]] std::string Get(std::string_view attribute, std::string_view fallback = {}) const;
  // Line of the attribute, or of the element when it is absent.
  [[nodiscard]] int LineOf(std::string_view attribute) const;
};

// Reads a file and returns its root element, or one diagnostic for a missing file or malformed XML (with the parser's
// line and message). Neither external entities nor the network are used.
tl::expected<XmlElement, std::vector<Diagnostic>> ReadXml(const std::filesystem::path& file);

}  // namespace scene
