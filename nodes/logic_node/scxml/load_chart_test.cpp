#include "nodes/logic_node/scxml/load_chart.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "nodes/logic_node/scxml/analyse_chart.hpp"

namespace logic_node::scxml {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

// `lines` start at line 2 of the file.
std::vector<std::string> Complaints(const std::string& lines) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / ("vr_oos_chart_" + std::to_string(::getpid()) + ".scxml");
  std::ofstream(file) << "<scxml xmlns='" << kScxmlNamespace << "' xmlns:vr='" << kProcedureNamespace
                      << "' version='1.0'>\n"
                      << lines << "\n</scxml>\n";
  const auto chart = LoadChart(file, {});
  std::filesystem::remove(file);
  std::vector<std::string> texts;
  const auto diagnostics = chart ? AnalyseChart(*chart) : chart.error();
  for (const scene::Diagnostic& diagnostic : diagnostics) {
    EXPECT_FALSE(diagnostic.why.empty() || diagnostic.fix.empty());
    texts.push_back(std::to_string(diagnostic.where.line) + ": " + diagnostic.what + ": " + diagnostic.why + ". " +
                    diagnostic.fix);
  }
  return texts;
}

const std::string kGood = R"(<state id="procedure">
  <state id="one"><transition event="e" target="two" vr:completes="true"/></state>
  <state id="two"><transition event="e" target="done" vr:completes="true"/></state>
  <final id="done"/></state>)";

TEST(LoadChart, AValidProcedureHasNoDiagnostics) {
  EXPECT_THAT(Complaints(kGood), testing::IsEmpty());
}

struct BadCase {
  const char* title;
  const char* lines;
  int line;
  const char* says;
};

class LoadChartBadCases : public testing::TestWithParam<BadCase> {};

TEST_P(LoadChartBadCases, ReportsLineAndCause) {
  const std::string lines = GetParam().lines + std::string("\n") + kGood;
  EXPECT_THAT(Complaints(lines),
              Contains(AllOf(testing::StartsWith(std::to_string(GetParam().line) + ": "), HasSubstr(GetParam().says))));
}

const BadCase kBadCases[] = {
    {"Script", "<state id='s'><onentry>\n<script>x()</script></onentry></state>", 3, "procedures run no scripts"},
    {"Invoke", "<state id='s'>\n<invoke/></state>", 3, "start no other services"},
    {"Foreach", "<state id='s'><onentry>\n<foreach/></onentry></state>", 3, "single numbers"},
    {"UnknownElement", "<stat id='s'/>", 2, "did you mean 'state'"},
    {"UnknownAttribute", "<state id='s'>\n<transition\n evnt='e'/></state>", 4, "did you mean 'event'"},
    {"ForeignNamespace", "<x:state xmlns:x='urn:other' id='s'/>", 2, "urn:other"},
    {"UnknownTarget", "<state id='s'>\n<transition event='e' target='don'/></state>", 3, "did you mean 'done'"},
    {"UnknownTargetOfInitial", "<state id='s' initial='gone'><state id='t'/></state>", 2, "unknown target 'gone'"},
    {"InitialOutside", "<state id='s' initial='one'><state id='t'/></state>", 2, "not inside"},
    {"SameId", "<state id='one'/>", 4, "taken by line 2"},
    {"UnknownSignal", "<state id='s'>\n<transition\n cond='latch.state == 1' target='one'/></state>", 4,
     "unknown name 'latch.state'"},
    {"ConditionIsNumber", "<state id='s'><transition cond='1 + 1' target='one'/></state>", 2, "is a number"},
    {"EmptyCondition", "<state id='s'><transition cond='' target='one'/></state>", 2, "cond is missing"},
    {"RampWithoutTime", "<state id='s'><onentry>\n<vr:set name='k' value='1' over_s='0'/></onentry></state>", 3,
     "over_s is '0'"},
    {"ChangeWhenever", "<state id='s'><onentry>\n<vr:set name='k' value='1' when='soon'/></onentry></state>", 3,
     "when is 'soon'"},
    {"UnknownParameter", "<state id='s'><onentry>\n<vr:set name='p' value='1'/></onentry></state>", 3,
     "unknown parameter 'p'"},
    {"UnknownLamp", "<state id='s'><onentry>\n<vr:lamp object='l' color='1 0 0'/></onentry></state>", 3, "not a lamp"},
    {"BadColor", "<state id='s'><onentry>\n<vr:lamp object='l' color='red'/></onentry></state>", 3, "color is 'red'"},
    {"BadDelay", "<state id='s'><onentry>\n<send event='e' delay='3 minutes'/></onentry></state>", 3, "delay"},
    {"NegativeDelay", "<state id='s'><onentry>\n<send event='e' delay='-1s'/></onentry></state>", 3, "delay"},
    {"DeepHistory",
     "<state id='s'><history id='h' type='deep'>\n<transition target='t'/></history><state id='t'/></state>", 2,
     "only shallow"},
    {"HistoryWithoutDefault", "<state id='s'><history id='h'/><state id='t'/></state>", 2, "0 transitions"},
    {"UnknownData", "<state id='s'><onentry>\n<assign location='n' expr='1'/></onentry></state>", 3,
     "unknown location"},
    {"TargetsTogether", "<state id='s'><transition event='e' target='one two'/></state>", 2, "active together"},
    {"UnknownDone", "<state id='s'><transition event='done.state.procedur' target='one'/></state>", 2,
     "did you mean 'procedure'"},
    {"EndlessTransition", "<state id='s'><transition/></state>", 2, "taken endlessly"},
    {"BadCompletes", "<state id='s'><transition event='e' target='one' vr:completes='yes'/></state>", 2,
     "true or false"},
    {"HistoryAtTop", "<history id='h'><transition target='one'/></history>", 2, "does not allow"},
    {"FinalInParallel", "<parallel id='p'>\n<final id='f'/></parallel>", 3, "does not allow"},
    {"ElseTwice", "<state id='s'><onentry><if cond='true'><else/>\n<else/></if></onentry></state>", 3, "last branch"},
};

INSTANTIATE_TEST_SUITE_P(All, LoadChartBadCases, testing::ValuesIn(kBadCases),
                         [](const auto& param_info) { return std::string(param_info.param.title); });

TEST(AnalyseChart, ReportsAnUnreachableStateWithItsLine) {
  EXPECT_THAT(Complaints(R"(<state id="procedure">
    <state id="one"><transition event="e" target="done" vr:completes="true"/></state>
    <state id="lost"><transition event="e" target="done" vr:completes="true"/></state>
    <final id="done"/></state>)"),
              testing::ElementsAre(HasSubstr("4: state 'lost' cannot be reached")));
}

TEST(AnalyseChart, ATransitionWithAFalseConditionReachesNothing) {
  EXPECT_THAT(Complaints(R"(<state id="procedure">
    <state id="one"><transition event="e" target="done" vr:completes="true"/>
       <transition cond="1 == 2" target="lost"/></state>
    <state id="lost"><transition event="e" target="done" vr:completes="true"/></state>
    <final id="done"/></state>)"),
              testing::ElementsAre(HasSubstr("5: state 'lost' cannot be reached")));
}

TEST(AnalyseChart, ReportsAnUnreachableBranchOnce) {
  EXPECT_THAT(Complaints(kGood + "<state id='x'><state id='y'/><state id='z'/></state>"),
              testing::ElementsAre(HasSubstr("'x'")));
}

TEST(AnalyseChart, StatesReachedThroughParallelAndHistoryAreReachable) {
  EXPECT_THAT(Complaints(R"(<parallel id="all">
    <state id="lamp"><history id="h"><transition target="red"/></history>
      <state id="green"><transition event="e" target="away"/></state><state id="red"/>
      <state id="away"><transition event="e" target="h"/></state></state>)" +
                         kGood + "</parallel>"),
              testing::IsEmpty());
}

TEST(AnalyseChart, ReportsAMissingProcedureFinalStateOrPath) {
  EXPECT_THAT(Complaints("<state id='other'/>"), Contains(HasSubstr("no state 'procedure'")));
  EXPECT_THAT(Complaints("<state id='procedure'><state id='one'/></state>"), Contains(HasSubstr("no final state")));
  EXPECT_THAT(Complaints("<state id='procedure'>\n<state id='one'><transition event='e' target='done'/></state>"
                         "<final id='done'/></state>"),
              Contains(HasSubstr("3: step 'one' can never be completed")));
  EXPECT_THAT(Complaints("<state id='procedure'>\n<state id='one'><transition event='e' target='done' "
                         "vr:completes='true'/><transition event='f' target='pit' vr:completes='true'/></state>\n"
                         "<state id='pit'/>\n<final id='done'/></state>"),
              Contains(HasSubstr("4: no path leads from step 'pit'")));
}

TEST(LoadChart, ReportsMalformedXml) {
  EXPECT_THAT(Complaints("<state id='procedure'>\n<state>\n</state>"), Contains(HasSubstr("malformed XML")));
}

}  // namespace
}  // namespace logic_node::scxml
