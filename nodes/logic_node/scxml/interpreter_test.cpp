#include "nodes/logic_node/scxml/interpreter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <memory>
#include <random>

#include "core/clock.hpp"
#include "nodes/logic_node/scxml/load_chart.hpp"

namespace logic_node::scxml {
namespace {

using testing::ElementsAre;

// Runs a chart and logs its effects. Signals: `x` and `y`.
class Runner final : private Host {
 public:
  explicit Runner(const std::string& body) {
    const std::filesystem::path file =
        std::filesystem::path(testing::TempDir()) / ("vr_oos_interpreter_" + std::to_string(::getpid()) + ".scxml");
    std::ofstream(file) << "<scxml xmlns='" << kScxmlNamespace << "' xmlns:vr='" << kProcedureNamespace << "' " << body
                        << "</scxml>";
    Vocabulary vocabulary;
    vocabulary.find_signal = [](const std::string& name) -> std::optional<Symbol> {
      if (name == "x") return Symbol{SymbolKind::kSignal, Type::kNumber, 0};
      if (name == "y") return Symbol{SymbolKind::kSignal, Type::kNumber, 1};
      return std::nullopt;
    };
    vocabulary.is_parameter = [](const std::string&) { return true; };
    auto chart = LoadChart(file, vocabulary);
    std::filesystem::remove(file);
    if (!chart) {
      ADD_FAILURE() << scene::Format(chart.error().front());
      return;
    }
    chart_ = std::move(*chart);
    Host* host = this;
    interpreter_ = std::make_unique<Interpreter>(chart_, host);
    interpreter_->Start(0, &signals_);
  }

  // Sends events at the current time; returns the log since the last call.
  std::vector<std::string> Send(const std::vector<std::string>& events) {
    interpreter_->Advance(now_ns_, events);
    return Log();
  }
  std::vector<std::string> Wait(std::int64_t duration_ns) {
    now_ns_ += duration_ns;
    return Send({});
  }
  std::vector<std::string> Log() { return std::exchange(log_, {}); }
  [[nodiscard]] std::vector<std::string> Active() const {
    std::vector<std::string> ids;
    for (const int state : interpreter_->Configuration()) ids.push_back(chart_.At(state).id);
    return ids;
  }

  Chart chart_;
  std::vector<double> signals_{0.0, 0.0};
  std::unique_ptr<Interpreter> interpreter_;
  std::int64_t now_ns_ = 0;
  std::vector<double> set_values_;

 private:
  void OnEnter(int state, std::int64_t) override { log_.push_back("+" + chart_.At(state).id); }
  void OnExit(int state, const Transition&, std::int64_t) override { log_.push_back("-" + chart_.At(state).id); }
  void OnAction(const Action& action, double value) override {
    if (action.kind == ActionKind::kSetParameter) set_values_.push_back(value);
    std::string text = action.text;
    if (action.kind == ActionKind::kLog && !action.value.empty()) text += FormatNumber(value);
    log_.push_back(text);
  }

  std::vector<std::string> log_;
};

TEST(Interpreter, EntersOuterBeforeInnerAndExitsInnerBeforeOuter) {
  Runner run(R"(>
    <state id="a"><onentry><log label="in a"/></onentry><onexit><log label="out a"/></onexit>
      <state id="a1"><onentry><log label="in a1"/></onentry><onexit><log label="out a1"/></onexit>
        <transition event="go" target="b"><log label="go"/></transition></state></state>
    <state id="b"/>)");
  EXPECT_THAT(run.Log(), ElementsAre("+a", "in a", "+a1", "in a1"));
  EXPECT_THAT(run.Send({"go"}), ElementsAre("out a1", "-a1", "out a", "-a", "go", "+b"));
}

TEST(Interpreter, TakesTheFirstEnabledTransitionInDocumentOrder) {
  Runner run(R"(>
    <state id="a"><transition event="e" cond="x == 1" target="b"/><transition event="e" target="c"/>
                  <transition event="e" target="b"/></state>
    <state id="b"/><state id="c"/>)");
  run.Send({"e"});
  EXPECT_THAT(run.Active(), ElementsAre("c"));
}

TEST(Interpreter, InnerStateOverridesOuter) {
  Runner run(R"(>
    <state id="a"><transition event="e" target="b"/><state id="a1"><transition event="e" target="a2"/></state>
      <state id="a2"/></state><state id="b"/>)");
  run.Send({"e"});
  EXPECT_THAT(run.Active(), ElementsAre("a", "a2"));
  run.Send({"e"});
  EXPECT_THAT(run.Active(), ElementsAre("b"));
}

TEST(Interpreter, EventDescriptorsMatchByTokens) {
  EXPECT_TRUE(Matches("engage", "engage.latch_a"));
  EXPECT_TRUE(Matches("*", "anything"));
  EXPECT_FALSE(Matches("engage", "engaged"));
  EXPECT_FALSE(Matches("engage.latch_a", "engage"));
  Runner run(R"(><state id="a"><transition event="x y.*" target="b"/></state><state id="b"/>)");
  run.Send({"yes"});
  EXPECT_THAT(run.Active(), ElementsAre("a"));
  run.Send({"y.z"});
  EXPECT_THAT(run.Active(), ElementsAre("b"));
}

TEST(Interpreter, ParallelRegionsRunSideBySide) {
  Runner run(R"(>
    <parallel id="p">
      <state id="a"><state id="a1"><transition event="e" target="a2"/></state><state id="a2"/></state>
      <state id="b"><state id="b1"><transition event="e" target="b2"/></state><state id="b2"/></state>
    </parallel>)");
  EXPECT_THAT(run.Active(), ElementsAre("p", "a", "a1", "b", "b1"));
  run.Log();
  // Both in one microstep: exits before entries, in reverse and in document order.
  EXPECT_THAT(run.Send({"e"}), ElementsAre("-b1", "-a1", "+a2", "+b2"));
}

TEST(Interpreter, InAConflictOfRegionsTheEarlierOneIsTaken) {
  Runner run(R"(>
    <parallel id="p">
      <state id="a"><transition event="e" target="out_a"/></state>
      <state id="b"><transition event="e" target="out_b"/></state>
    </parallel><state id="out_a"/><state id="out_b"/>)");
  run.Send({"e"});
  EXPECT_THAT(run.Active(), ElementsAre("out_a"));
}

TEST(Interpreter, InnerSourcePreemptsOuterSourceOfAnotherRegion) {
  // The transition of s would exit b1, so it conflicts with that of b1, whose source is inside s.
  Runner run(R"(>
    <state id="s" initial="p"><transition event="e" target="out"/>
      <parallel id="p">
        <state id="a"/>
        <state id="b"><state id="b1"><transition event="e" target="b2"/></state><state id="b2"/></state>
      </parallel></state><state id="out"/>)");
  run.Send({"e"});
  EXPECT_THAT(run.Active(), ElementsAre("s", "p", "a", "b", "b2"));
}

TEST(Interpreter, TransitionIntoOneRegionEntersTheOthersByDefault) {
  Runner run(R"(initial="s">
    <state id="s"><transition event="e" target="b2"/></state>
    <parallel id="p">
      <state id="a" initial="a2"><state id="a1"/><state id="a2"/></state>
      <state id="b"><state id="b1"/><state id="b2"/></state>
    </parallel>)");
  run.Send({"e"});
  EXPECT_THAT(run.Active(), ElementsAre("p", "a", "a2", "b", "b2"));
}

TEST(Interpreter, SeveralTargetsEnterSeveralRegions) {
  Runner run(R"(initial="a2 b2">
    <parallel id="p">
      <state id="a"><state id="a1"/><state id="a2"/></state><state id="b"><state id="b1"/><state id="b2"/></state>
    </parallel>)");
  EXPECT_THAT(run.Active(), ElementsAre("p", "a", "a2", "b", "b2"));
}

TEST(Interpreter, AParallelStateIsDoneWhenEveryRegionIsFinal) {
  Runner run(R"(>
    <state id="s" initial="p"><transition event="done.state.p" target="out"/>
      <parallel id="p">
        <state id="a"><state id="a1"><transition event="x" target="a2"/></state><final id="a2"/></state>
        <state id="b"><state id="b1"><transition event="y" target="b2"/></state><final id="b2"/></state>
      </parallel></state><state id="out"/>)");
  run.Send({"x"});
  EXPECT_THAT(run.Active(), ElementsAre("s", "p", "a", "a2", "b", "b1"));
  run.Send({"y"});
  EXPECT_THAT(run.Active(), ElementsAre("out"));
}

TEST(Interpreter, ShallowHistoryRestoresTheChildNotTheGrandchild) {
  Runner run(R"(>
    <state id="a"><history id="h"><transition target="a1"><log label="default"/></transition></history>
      <transition event="leave" target="b"/>
      <state id="a1"><transition event="next" target="a2"/></state>
      <state id="a2"><state id="a21"><transition event="next" target="a22"/></state><state id="a22"/></state></state>
    <state id="b"><transition event="back" target="h"/></state>)");
  run.Send({"next", "next"});
  EXPECT_THAT(run.Active(), ElementsAre("a", "a2", "a22"));
  run.Send({"leave"});
  run.Log();
  EXPECT_THAT(run.Send({"back"}), ElementsAre("-b", "+a", "+a2", "+a21"));
}

TEST(Interpreter, AnEmptyHistoryTakesItsDefaultTransitionWithItsActions) {
  Runner run(R"(initial="b">
    <state id="a"><history id="h"><transition target="a2"><log label="default"/></transition></history>
      <state id="a1"/><state id="a2"/></state>
    <state id="b"><transition event="back" target="h"/></state>)");
  run.Log();
  EXPECT_THAT(run.Send({"back"}), ElementsAre("-b", "+a", "default", "+a2"));
}

TEST(Interpreter, InternalTransitionKeepsItsSourceActive) {
  const std::string chart = R"(>
    <state id="a"><transition event="e" TYPE target="a2"/><state id="a1"/><state id="a2"/></state>)";
  const auto with = [&](const std::string& type) {
    std::string text = chart;
    return text.replace(text.find("TYPE"), 4, type);
  };
  Runner internal(with("type='internal'"));
  internal.Log();
  EXPECT_THAT(internal.Send({"e"}), ElementsAre("-a1", "+a2"));
  Runner external(with(""));
  external.Log();
  EXPECT_THAT(external.Send({"e"}), ElementsAre("-a1", "-a", "+a", "+a2"));
}

TEST(Interpreter, TargetlessTransitionChangesNoState) {
  Runner run(R"(><state id="a"><transition event="e"><log label="done"/></transition></state>)");
  run.Log();
  EXPECT_THAT(run.Send({"e"}), ElementsAre("done"));
}

TEST(Interpreter, RaisedEventsComeBeforeSentOnesAndEventlessBeforeBoth) {
  Runner run(R"(>
    <state id="a"><onentry><send event="sent"/><raise event="raised"/></onentry>
      <transition event="sent" target="bad"/><transition event="raised" target="bad"/><transition cond="x == 0" target="b"/>
    </state>
    <state id="b"><transition event="sent" target="bad"/><transition event="raised" target="c"/></state>
    <state id="c"><transition event="sent" target="d"/></state><state id="d"/><state id="bad"/>)");
  EXPECT_THAT(run.Active(), ElementsAre("d"));
}

TEST(Interpreter, EventlessTransitionFollowsTheSignals) {
  Runner run(R"(><state id="a"><transition cond="x &gt; 0.5" target="b"/></state><state id="b"/>)");
  run.Send({});
  EXPECT_THAT(run.Active(), ElementsAre("a"));
  run.signals_[0] = 0.6;
  run.Send({});
  EXPECT_THAT(run.Active(), ElementsAre("b"));
}

TEST(Interpreter, DataAssignIfAndIn) {
  Runner run(R"x(>
    <datamodel><data id="n" expr="2"/><data id="twice" expr="n * 2"/></datamodel>
    <state id="a"><transition event="e"><assign location="n" expr="n + twice"/>
      <if cond="n == 6"><log label="six"/><elseif cond="n == 10 &amp;&amp; In('a')"/><log label="ten"/>
        <else/><log label="other" expr="n"/></if></transition></state>)x");
  run.Log();
  EXPECT_THAT(run.Send({"e", "e", "e"}), ElementsAre("six", "ten", "other14"));
}

TEST(Interpreter, DelaysCountBusTimeAndCanBeCancelled) {
  Runner run(R"(>
    <state id="a"><onentry><send event="late" delay="3s" id="t"/><send event="soon" delay="500ms"/></onentry>
      <transition event="soon" target="b"/><transition event="late" target="bad"/></state>
    <state id="b"><onexit><cancel sendid="t"/></onexit>
      <transition event="go" target="c"/><transition event="late" target="bad"/></state>
    <state id="c"><transition event="late" target="bad"/></state><state id="bad"/>)");
  run.Wait(499'999'999);
  EXPECT_THAT(run.Active(), ElementsAre("a"));
  run.Wait(1);
  EXPECT_THAT(run.Active(), ElementsAre("b"));
  run.Send({"go"});
  run.Wait(10 * core::kNanosecondsPerSecond);
  EXPECT_THAT(run.Active(), ElementsAre("c"));
}

TEST(Interpreter, DueEventsComeInTheOrderOfTheirTimesThenOfSending) {
  Runner run(R"(>
    <state id="a"><onentry><send event="c" delay="2s"/><send event="a" delay="1s"/><send event="b" delay="1s"/></onentry>
      <transition event="a"><log label="a"/></transition><transition event="b"><log label="b"/></transition>
      <transition event="c"><log label="c"/></transition></state>)");
  run.Log();
  EXPECT_THAT(run.Wait(5 * core::kNanosecondsPerSecond), ElementsAre("a", "b", "c"));
}

// A chain of delays ends at their sum for any step, since each event is processed at its due time.
TEST(Interpreter, DelaysOfTenMinutesAddUpExactly) {
  for (const std::int64_t step_ns :
       {std::int64_t{10'000'000}, 7 * core::kNanosecondsPerSecond, 700 * core::kNanosecondsPerSecond}) {
    Runner run(R"(>
      <datamodel><data id="n" expr="0"/></datamodel>
      <state id="tick"><onentry><send event="t" delay="1.5s"/></onentry>
        <transition event="t" cond="n &lt; 399" target="tick"><assign location="n" expr="n + 1"/></transition>
        <transition event="t" target="end"/></state>
      <state id="end"><onentry><send event="u" delay="10s"/></onentry><transition event="u" target="over"/></state>
      <final id="over"/>)");
    // 400 x 1.5 s + 10 s = 610 s
    while (run.now_ns_ < 609 * core::kNanosecondsPerSecond && step_ns < 600 * core::kNanosecondsPerSecond)
      run.Wait(step_ns);
    if (run.now_ns_ < 610 * core::kNanosecondsPerSecond) {
      EXPECT_TRUE(run.interpreter_->is_running());
    }
    run.Wait(610 * core::kNanosecondsPerSecond > run.now_ns_ ? 610 * core::kNanosecondsPerSecond - run.now_ns_ : 0);
    EXPECT_FALSE(run.interpreter_->is_running()) << step_ns;
  }
}

TEST(Interpreter, TopLevelFinalEndsTheRun) {
  Runner run(R"(><state id="a"><transition event="e" target="f"/></state><final id="f"/>)");
  EXPECT_TRUE(run.interpreter_->is_running());
  run.Send({"e"});
  EXPECT_FALSE(run.interpreter_->is_running());
}

TEST(Interpreter, StopsAnEndlessLoopOfTransitions) {
  Runner run(R"(>
    <state id="a"><transition cond="x == 1" target="b"/></state><state id="b"><transition cond="x == 1" target="a"/></state>)");
  EXPECT_FALSE(run.interpreter_->is_circling());
  run.signals_[0] = 1.0;
  run.Send({});
  EXPECT_TRUE(run.interpreter_->is_circling());
  EXPECT_FALSE(run.interpreter_->is_running());
}

TEST(Interpreter, AParameterThatIsNotFiniteRaisesAnErrorInsteadOfBeingSent) {
  Runner run(R"(>
    <state id="a"><transition event="e"><vr:set name="p" value="1 / x"/></transition>
      <transition event="error.execution" target="b"/></state><state id="b"/>)");
  run.Send({"e"});
  EXPECT_TRUE(run.set_values_.empty());
  EXPECT_THAT(run.Active(), ElementsAre("b"));
}

// A legal configuration: exactly one child of each active compound state, all children of each active parallel state,
// none of an inactive state.
void ExpectLegal(const Runner& run) {
  for (std::size_t i = 0; i < run.chart_.states.size(); ++i) {
    const State& state = run.chart_.states[i];
    int num_active = 0;
    for (const int child : state.children) num_active += run.interpreter_->IsActive(child) ? 1 : 0;
    const bool is_active = i == 0 || run.interpreter_->IsActive(static_cast<int>(i));
    if (!is_active) {
      ASSERT_EQ(num_active, 0) << state.id;
    }
    if (is_active && state.is_compound()) {
      ASSERT_EQ(num_active, 1) << state.id;
    }
    if (is_active && state.kind == StateKind::kParallel) {
      ASSERT_EQ(num_active, static_cast<int>(state.children.size())) << state.id;
    }
    if (state.kind == StateKind::kHistory) {
      ASSERT_FALSE(run.interpreter_->IsActive(static_cast<int>(i)));
    }
  }
}

constexpr const char* kTangle = R"(initial="procedure">
  <state id="procedure" initial="p">
    <history id="hp"><transition target="p"/></history>
    <parallel id="p">
      <history id="hpar"><transition target="a2"/></history>
      <transition event="e5" target="q"/>
      <state id="a"><history id="ha"><transition target="a2"/></history>
        <transition event="e4" type="internal" target="a3"/>
        <state id="a1"><transition event="e1" target="a2"/></state>
        <state id="a2"><transition event="e1" target="a3"/><transition event="e2" target="b2 a1"/></state>
        <state id="a3" initial="a31"><state id="a31"><transition event="e3" target="a32"/></state>
          <state id="a32"><transition event="e2" target="q1"/></state></state></state>
      <state id="b"><onentry><send event="e3" delay="30ms" id="s"/></onentry><onexit><cancel sendid="s"/></onexit>
        <state id="b1"><transition event="e1 e2" target="b2"/></state>
        <state id="b2"><transition event="e3" target="b1"><raise event="e4"/></transition>
          <parallel id="b2p"><state id="b2x"><transition event="e6"><log label="x"/></transition></state><state id="b2y">
            <state id="b2y1"><transition event="e6" target="b2y2"/></state><final id="b2y2"/></state></parallel></state>
      </state>
    </parallel>
    <state id="q"><state id="q1"><transition event="e1" target="hp"/></state>
      <state id="q2"><transition event="e2" target="ha"/><transition event="e6" target="hpar"/></state>
      <transition event="e3" type="internal" target="q2"/><transition event="e4" target="b2y1 a32"/>
      <transition event="done.state.b2y" target="q2"/></state>
  </state>)";

std::string RandomEvent(std::mt19937_64* random) {
  return std::string(1, 'e') + static_cast<char>('1' + (*random)() % 6);
}

TEST(Interpreter, RandomEventsKeepEveryConfigurationLegal) {
  Runner run(kTangle);
  ASSERT_TRUE(run.interpreter_);
  std::mt19937_64 random(11);
  std::vector<int> visits(run.chart_.states.size(), 0);
  for (int i = 0; i < 100000; ++i) {
    run.now_ns_ += static_cast<std::int64_t>(random() % 20) * 1'000'000;
    run.Send({RandomEvent(&random)});
    ExpectLegal(run);
    if (testing::Test::HasFatalFailure()) FAIL() << "after event " << i;
    for (const int state : run.interpreter_->Configuration()) ++visits[static_cast<std::size_t>(state)];
  }
  for (std::size_t i = 1; i < visits.size(); ++i) {
    if (run.chart_.states[i].kind != StateKind::kHistory) {
      EXPECT_GT(visits[i], 0) << run.chart_.states[i].id;
    }
  }
}

TEST(Interpreter, EqualEventsGiveEqualRuns) {
  std::vector<std::vector<std::string>> logs;
  for (int run_index = 0; run_index < 2; ++run_index) {
    Runner run(kTangle);
    std::mt19937_64 random(5);
    for (int i = 0; i < 1000; ++i) {
      run.now_ns_ += 10'000'000;
      run.interpreter_->Advance(run.now_ns_, {RandomEvent(&random)});
    }
    logs.push_back(run.Log());
  }
  EXPECT_GT(logs[0].size(), 1000U);
  EXPECT_EQ(logs[0], logs[1]);
}

}  // namespace
}  // namespace logic_node::scxml
