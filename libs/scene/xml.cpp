#include "scene/xml.hpp"

#include <libxml/parser.h>
#include <libxml/tree.h>
#include <libxml/xmlerror.h>

#include <algorithm>
#include <cctype>
#include <memory>

#include "core/read_file.hpp"

namespace scene {
namespace {

struct DocumentDeleter {
  void operator()(xmlDoc* document) const { xmlFreeDoc(document); }
};
struct ContextDeleter {
  void operator()(xmlParserCtxt* context) const { xmlFreeParserCtxt(context); }
};
struct StringDeleter {
  void operator()(xmlChar* text) const { xmlFree(text); }
};

struct ParseError {
  int line = 0;
  std::string message;
};

// libxml2 calls this for every error. Only the first is kept; the others follow from it.
#if LIBXML_VERSION >= 21200
void KeepFirstError(void* user_data, const xmlError* error) {
#else
void KeepFirstError(void* user_data, xmlErrorPtr error) {
#endif
  auto* first = static_cast<ParseError*>(static_cast<xmlParserCtxt*>(user_data)->_private);
  if (error->level < XML_ERR_ERROR || !first->message.empty()) return;
  first->line = error->line;
  first->message = error->message != nullptr ? error->message : "unknown error";
  while (!first->message.empty() && std::isspace(static_cast<unsigned char>(first->message.back())) != 0) {
    first->message.pop_back();
  }
}

std::string ToString(const xmlChar* text) {
  return text == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(text));
}

bool IsSpace(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

std::string Trimmed(const std::string& text) {
  const auto begin = std::find_if_not(text.begin(), text.end(), IsSpace);
  const auto end = std::find_if_not(text.rbegin(), std::make_reverse_iterator(begin), IsSpace).base();
  return {begin, end};
}

// Finds the line of each start tag and attribute in the text; libxml2 knows only the line on which a start tag ends.
class LineFinder {
 public:
  explicit LineFinder(std::string_view text) : text_(text) {
    line_starts_.push_back(0);
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') line_starts_.push_back(i + 1);
    }
  }

  // Fills element->line and the lines of its attributes. `qualified_name` is the tag as written, with its prefix.
  void Place(const std::string& qualified_name, int end_line, const std::vector<std::string>& qualified_attributes,
             XmlElement* element) const {
    element->line = end_line;
    for (XmlAttribute& attribute : element->attributes) attribute.line = end_line;
    const std::size_t start = FindTag("<" + qualified_name, end_line);
    if (start == std::string_view::npos) return;
    element->line = LineAt(start);
    // Inside a well-formed start tag: blanks, name, '=', quoted value, again and again until '>' or '/'.
    std::size_t at = start + 1 + qualified_name.size();
    while (true) {
      while (at < text_.size() && IsSpace(text_[at])) ++at;
      if (at >= text_.size() || text_[at] == '>' || text_[at] == '/') return;
      const std::size_t name_start = at;
      while (at < text_.size() && text_[at] != '=' && !IsSpace(text_[at])) ++at;
      const std::string_view name = text_.substr(name_start, at - name_start);
      const std::size_t quote = text_.find_first_of("\"'", at);
      if (quote == std::string_view::npos) return;
      const std::size_t close = text_.find(text_[quote], quote + 1);
      if (close == std::string_view::npos) return;
      for (std::size_t i = 0; i < qualified_attributes.size(); ++i) {
        if (qualified_attributes[i] == name) element->attributes[i].line = LineAt(name_start);
      }
      at = close + 1;
    }
  }

 private:
  [[nodiscard]] std::size_t FindTag(const std::string& tag, int end_line) const {
    const auto end = static_cast<std::size_t>(std::max(end_line, 1));
    std::size_t from = end < line_starts_.size() ? line_starts_[end] - 1 : text_.size();
    while (true) {
      const std::size_t found = text_.rfind(tag, from);
      if (found == std::string_view::npos) return found;
      const std::size_t after = found + tag.size();
      if (after < text_.size() && (IsSpace(text_[after]) || text_[after] == '>' || text_[after] == '/')) return found;
      if (found == 0) return std::string_view::npos;
      from = found - 1;
    }
  }
  [[nodiscard]] int LineAt(std::size_t position) const {
    return static_cast<int>(std::upper_bound(line_starts_.begin(), line_starts_.end(), position) -
                            line_starts_.begin());
  }

  std::string_view text_;
  std::vector<std::size_t> line_starts_;
};

std::string QualifiedName(const xmlNs* ns, const xmlChar* name) {
  if (ns != nullptr && ns->prefix != nullptr) return ToString(ns->prefix) + ":" + ToString(name);
  return ToString(name);
}

XmlElement Convert(xmlNode* node, const LineFinder& lines) {
  XmlElement element;
  element.name = ToString(node->name);
  if (node->ns != nullptr) element.name_space = ToString(node->ns->href);
  std::vector<std::string> qualified_attributes;
  for (xmlAttr* attribute = node->properties; attribute != nullptr; attribute = attribute->next) {
    const std::unique_ptr<xmlChar, StringDeleter> value(xmlNodeListGetString(node->doc, attribute->children, 1));
    element.attributes.push_back({attribute->ns != nullptr ? ToString(attribute->ns->href) : std::string(),
                                  ToString(attribute->name), ToString(value.get()), 0});
    qualified_attributes.push_back(QualifiedName(attribute->ns, attribute->name));
  }
  lines.Place(QualifiedName(node->ns, node->name), static_cast<int>(xmlGetLineNo(node)), qualified_attributes,
              &element);
  for (xmlNode* child = node->children; child != nullptr; child = child->next) {
    if (child->type == XML_ELEMENT_NODE) element.children.push_back(Convert(child, lines));
    if (child->type == XML_TEXT_NODE || child->type == XML_CDATA_SECTION_NODE) element.text += ToString(child->content);
  }
  element.text = Trimmed(element.text);
  return element;
}

tl::unexpected<std::vector<Diagnostic>> SingleError(Diagnostic diagnostic) {
  return tl::unexpected<std::vector<Diagnostic>>({std::move(diagnostic)});
}

}  // namespace

const XmlAttribute* XmlElement::Find(std::string_view attribute, std::string_view uri) const {
  for (const XmlAttribute& candidate : attributes) {
    if (candidate.name == attribute && candidate.name_space == uri) return &candidate;
  }
  return nullptr;
}

std::string XmlElement::Get(std::string_view attribute, std::string_view fallback) const {
  const XmlAttribute* found = Find(attribute);
  return found != nullptr ? found->value : std::string(fallback);
}

int XmlElement::LineOf(std::string_view attribute) const {
  const XmlAttribute* found = Find(attribute);
  return found != nullptr ? found->line : line;
}

tl::expected<XmlElement, std::vector<Diagnostic>> ReadXml(const std::filesystem::path& file) {
  const auto bytes = core::ReadFile(file);
  if (!bytes) {
    return SingleError({{file, 0},
                        "cannot open '" + file.string() + "'",
                        "it " + bytes.error().detail,
                        "give the path of a file that exists"});
  }
  const std::string text(bytes->begin(), bytes->end());

  ParseError first_error;
  const std::unique_ptr<xmlParserCtxt, ContextDeleter> context(xmlNewParserCtxt());
  context->_private = &first_error;
  context->sax->serror = KeepFirstError;
  const std::unique_ptr<xmlDoc, DocumentDeleter> document(
      xmlCtxtReadMemory(context.get(), text.data(), static_cast<int>(text.size()), nullptr, nullptr,
                        XML_PARSE_NONET | XML_PARSE_BIG_LINES));
  if (document == nullptr || !first_error.message.empty()) {
    if (text.empty()) first_error.message = "the file is empty";
    return SingleError(
        {{file, first_error.line},
         "malformed XML",
         first_error.message,
         "correct the XML on this line or above it: each element must be closed, each attribute quoted"});
  }
  return Convert(xmlDocGetRootElement(document.get()), LineFinder(text));
}

}  // namespace scene
