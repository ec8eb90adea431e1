#include "scene/schema.hpp"

namespace scene {
namespace {

// XSD types of the attribute kinds. `number` excludes INF and NaN, which xs:double allows.
constexpr const char* kTypes = R"(
  <xs:simpleType name="name">
    <xs:restriction base="xs:string"><xs:pattern value="[^\s/]([^\s]*[^\s/])?"/></xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="file">
    <xs:restriction base="xs:string"><xs:minLength value="1"/></xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="number">
    <xs:restriction base="xs:double"><xs:pattern value="[+\-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+\-]?[0-9]+)?"/></xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="non_negative">
    <xs:restriction base="number"><xs:minInclusive value="0"/></xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="positive">
    <xs:restriction base="number"><xs:minExclusive value="0"/></xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="share">
    <xs:restriction base="number"><xs:minExclusive value="0"/><xs:maxExclusive value="1"/></xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="truth">
    <xs:restriction base="xs:string">
      <xs:enumeration value="true"/><xs:enumeration value="false"/>
      <xs:enumeration value="1"/><xs:enumeration value="0"/>
    </xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="fraction">
    <xs:restriction base="non_negative"><xs:maxInclusive value="1"/></xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="numbers"><xs:list itemType="number"/></xs:simpleType>
  <xs:simpleType name="vector">
    <xs:restriction base="numbers"><xs:length value="3"/></xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="fractions"><xs:list itemType="fraction"/></xs:simpleType>
  <xs:simpleType name="color">
    <xs:restriction base="fractions"><xs:length value="3"/></xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="instant">
    <xs:restriction base="xs:dateTime">
      <xs:pattern value="[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}Z"/>
      <xs:minInclusive value="1972-01-01T00:00:00Z"/><xs:maxExclusive value="2100-01-01T00:00:00Z"/>
    </xs:restriction>
  </xs:simpleType>
)";

// Names that other elements refer to.
constexpr const char* kKeys = R"(
    <xs:key name="object_name"><xs:selector xpath="object"/><xs:field xpath="@name"/></xs:key>
    <xs:unique name="device_role"><xs:selector xpath="device"/><xs:field xpath="@role"/></xs:unique>
    <xs:unique name="camera_name"><xs:selector xpath="camera"/><xs:field xpath="@name"/></xs:unique>
    <xs:unique name="parameter_name"><xs:selector xpath="parameter"/><xs:field xpath="@name"/></xs:unique>
    <xs:unique name="mechanism_name">
      <xs:selector xpath="hinge|snap|hook_and_loop"/><xs:field xpath="@name"/>
    </xs:unique>
    <xs:keyref name="pair_a" refer="object_name"><xs:selector xpath="pair"/><xs:field xpath="@a"/></xs:keyref>
    <xs:keyref name="pair_b" refer="object_name"><xs:selector xpath="pair"/><xs:field xpath="@b"/></xs:keyref>
    <xs:keyref name="mechanism_child" refer="object_name">
      <xs:selector xpath="hinge|snap|hook_and_loop"/><xs:field xpath="@child"/>
    </xs:keyref>
)";

const char* TypeName(ValueKind kind) {
  switch (kind) {
    case ValueKind::kText:
      return "xs:string";
    case ValueKind::kName:
      return "name";
    case ValueKind::kFile:
      return "file";
    case ValueKind::kNumber:
      return "number";
    case ValueKind::kNonNegative:
      return "non_negative";
    case ValueKind::kPositive:
      return "positive";
    case ValueKind::kShare:
      return "share";
    case ValueKind::kCount:
      return "xs:nonNegativeInteger";
    case ValueKind::kBoolean:
      return "truth";
    case ValueKind::kVector:
      return "vector";
    case ValueKind::kColor:
      return "color";
    case ValueKind::kNumbers:
      return "numbers";
    case ValueKind::kInstant:
      return "instant";
    case ValueKind::kChoice:
      return "xs:string";
  }
  return "xs:string";
}

std::string WriteAttribute(const AttributeRule& rule) {
  const std::string use = rule.is_required ? " use=\"required\"" : "";
  if (rule.kind != ValueKind::kChoice) {
    return "    <xs:attribute name=\"" + rule.name + "\" type=\"" + TypeName(rule.kind) + "\"" + use + "/>\n";
  }
  std::string text = "    <xs:attribute name=\"" + rule.name + "\"" + use + ">\n      <xs:simpleType>\n";
  text += "        <xs:restriction base=\"xs:string\">\n";
  for (const std::string& choice : rule.choices) {
    text += "          <xs:enumeration value=\"" + choice + "\"/>\n";
  }
  return text + "        </xs:restriction>\n      </xs:simpleType>\n    </xs:attribute>\n";
}

std::string WriteType(const ElementRule& rule) {
  std::string text = "\n  <xs:complexType name=\"" + rule.name + "_type\">\n";
  text += "    <xs:annotation><xs:documentation>" + rule.meaning + "</xs:documentation></xs:annotation>\n";
  if (!rule.children.empty()) {
    // Elements come in any order. XSD 1.0 cannot limit counts then, so only the loader checks them.
    text += "    <xs:choice minOccurs=\"0\" maxOccurs=\"unbounded\">\n";
    for (const ChildRule& child : rule.children) {
      text += "      <xs:element name=\"" + child.name + "\" type=\"" + child.name + "_type\"/>\n";
    }
    text += "    </xs:choice>\n";
  }
  for (const AttributeRule& attribute : rule.attributes) text += WriteAttribute(attribute);
  return text + "  </xs:complexType>\n";
}

}  // namespace

std::string WriteXsd() {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<!-- Written by scene::WriteXsd() from the rules in libs/scene/schema_rules.cpp; change those, then run\n"
      "     `scene_test` with VR_OOS_WRITE_XSD=1. `oos check` applies the same rules and more. -->\n"
      "<xs:schema xmlns:xs=\"http://www.w3.org/2001/XMLSchema\">\n";
  text += kTypes;
  for (const ElementRule& rule : ScenarioRules()) text += WriteType(rule);
  text += "\n  <xs:element name=\"" + ScenarioRules().front().name + "\" type=\"" + ScenarioRules().front().name +
          "_type\">";
  text += kKeys;
  text += "  </xs:element>\n</xs:schema>\n";
  return text;
}

}  // namespace scene
