#include "scene/schema.hpp"

#include <gtest/gtest.h>
#include <libxml/parser.h>
#include <libxml/xmlschemas.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>

namespace scene {
namespace {

const std::filesystem::path kXsdFile = std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / "scenario.xsd";

// Whether libxml2's schema processor accepts `xml` by the schema of WriteXsd().
bool IsValid(const std::string& xml) {
  const std::string xsd = WriteXsd();
  const std::unique_ptr<xmlSchemaParserCtxt, decltype(&xmlSchemaFreeParserCtxt)> parser(
      xmlSchemaNewMemParserCtxt(xsd.data(), static_cast<int>(xsd.size())), &xmlSchemaFreeParserCtxt);
  const std::unique_ptr<xmlSchema, decltype(&xmlSchemaFree)> schema(xmlSchemaParse(parser.get()), &xmlSchemaFree);
  EXPECT_NE(schema, nullptr) << "the schema itself is not valid";
  if (schema == nullptr) return false;
  const std::unique_ptr<xmlDoc, decltype(&xmlFreeDoc)> document(
      xmlReadMemory(xml.data(), static_cast<int>(xml.size()), nullptr, nullptr, XML_PARSE_NONET), &xmlFreeDoc);
  const std::unique_ptr<xmlSchemaValidCtxt, decltype(&xmlSchemaFreeValidCtxt)> validator(
      xmlSchemaNewValidCtxt(schema.get()), &xmlSchemaFreeValidCtxt);
  xmlSchemaSetValidStructuredErrors(
      validator.get(), [](void*, auto*) {}, nullptr);
  return xmlSchemaValidateDoc(validator.get(), document.get()) == 0;
}

std::string Wrap(const std::string& inner) {
  return "<scenario name='t'><procedure file='p'/><object name='a' owner='fixed'/>" + inner + "</scenario>";
}

TEST(Schema, CheckedInXsdMatchesTheRules) {
  if (std::getenv("VR_OOS_WRITE_XSD") != nullptr) std::ofstream(kXsdFile) << WriteXsd();
  std::ifstream stream(kXsdFile);
  std::stringstream text;
  text << stream.rdbuf();
  EXPECT_EQ(text.str(), WriteXsd()) << "run scene_test once with VR_OOS_WRITE_XSD=1";
}

TEST(Schema, XsdAndRulesAgreeOnValues) {
  struct Case {
    const char* xml;
    bool is_valid;
  };
  const Case cases[] = {
      {"", true},
      {"<sun direction='0 0 1'/>", true},
      {"<sun direction='0 0'/>", false},
      {"<sun direction='0 0 1' color='1'/>", false},
      {"<environment epoch='2014-03-01T12:00:00Z' altitude_km='400' inclination_deg='98.2' zenith='1 0 0'/>", true},
      {"<environment epoch='2014-02-30T12:00:00Z'/>", false},
      {"<environment epoch='2014-03-01T12:00:60Z'/>", false},
      {"<environment epoch='2014-03-01T12:00:00'/>", false},
      {"<environment epoch='1971-12-31T23:59:59Z'/>", false},
      {"<environment epoch='2100-01-01T00:00:00Z'/>", false},
      {"<environment altitude_km='0'/>", false},
      {"<run seed='1' force_cap_N='1e1' method='paper'/>", true},
      {"<run seed='-1'/>", false},
      {"<run accuracy='0.1'/>", true},
      {"<run accuracy='0'/>", false},
      {"<run accuracy='1'/>", false},
      {"<run force_cap_N='0'/>", false},
      {"<run gravity_m_per_s2='0 0 -9.81'/>", true},
      {"<run gravity_m_per_s2='-9.81'/>", false},
      {"<run method='guess'/>", false},
      {"<coupling type='god_object'/>", true},
      {"<coupling type='guess'/>", false},
      {"<parameter name='p' value='INF'/>", false},
      {"<parameter name='p' value='-.5'/>", true},
      {"<parameter value='1'/>", false},
      {"<object name='l' owner='fixed'><lamp color='0 1 0'/></object>", true},
      {"<object name='l' owner='fixed'><lamp color='0 2 0'/></object>", false},
      {"<object name='c' owner='fixed'><collision mesh='m'/></object>", true},
      {"<object name='c' owner='fixed'><collision accuracy_m='0.001'/></object>", false},
      {"<moon/>", false},
  };
  for (const Case& each : cases) {
    EXPECT_EQ(IsValid(Wrap(each.xml)), each.is_valid) << each.xml;
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "vr_oos_schema_test.xml";
    std::ofstream(file) << Wrap(each.xml);
    const auto root = ReadXml(file);
    ASSERT_TRUE(root);
    std::vector<Diagnostic> diagnostics;
    CheckAgainstRules(*root, file, &diagnostics);
    EXPECT_EQ(diagnostics.empty(), each.is_valid) << each.xml;
  }
}

TEST(Schema, XsdChecksReferences) {
  EXPECT_FALSE(IsValid(Wrap("<pair a='a' b='gone'/>")));
  EXPECT_TRUE(IsValid(Wrap("<object name='b' owner='fixed'/><pair a='a' b='b'/>")));
  EXPECT_FALSE(IsValid(Wrap("<object name='a' owner='fixed'/>")));
}

TEST(Schema, NumbersAreFiniteAndUseAPointInEveryLocale) {
  double value = 0.0;
  EXPECT_TRUE(ParseNumber(" -1.5e-3 ", &value));
  EXPECT_EQ(value, -1.5e-3);
  for (const char* bad : {"", "1,5", "nan", "inf", "1 2", "0x10", "1.0m", "--1"}) {
    EXPECT_FALSE(ParseNumber(bad, &value)) << bad;
  }
}

TEST(ReadXml, FindsTheLinesOfElementsAndAttributesOverSeveralLines) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "vr_oos_xml_test.xml";
  std::ofstream(file)
      << "<?xml version='1.0'?>\n<a\n  x='1'\n  xmlns:n='urn:n'\n  n:x='<2'\n>\n<!-- <b -->\n<b\n\n y='\n3'/></a>\n";
  const auto bad = ReadXml(file);  // '<' in an attribute is malformed
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error()[0].where.line, 5);
  std::ofstream(file)
      << "<?xml version='1.0'?>\n<a\n  x='1'\n  xmlns:n='urn:n'\n  n:x='2>'\n>\n<!-- <b -->\n<b\n\n y='\n3'/></a>\n";
  const auto root = ReadXml(file);
  ASSERT_TRUE(root);
  EXPECT_EQ(root->line, 2);
  EXPECT_EQ(root->LineOf("x"), 3);
  ASSERT_NE(root->Find("x", "urn:n"), nullptr);
  EXPECT_EQ(root->Find("x", "urn:n")->line, 5);
  EXPECT_EQ(root->Find("x", "urn:n")->value, "2>");
  ASSERT_EQ(root->children.size(), 1U);
  EXPECT_EQ(root->children[0].line, 8);
  EXPECT_EQ(root->children[0].LineOf("y"), 10);
}

}  // namespace
}  // namespace scene
