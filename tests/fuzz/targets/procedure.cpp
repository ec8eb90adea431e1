#include <string>
#include <vector>

#include "nodes/logic_node/scxml/analyse_chart.hpp"
#include "nodes/logic_node/scxml/interpreter.hpp"
#include "nodes/logic_node/scxml/load_chart.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/scratch_folder.hpp"
#include "tests/fuzz/targets.hpp"

namespace fuzz {
namespace {

using namespace logic_node;

// A small world: signals s0 to s3, parameter p, lamp l.
scxml::Vocabulary MakeVocabulary() {
  scxml::Vocabulary vocabulary;
  vocabulary.find_signal = [](const std::string& name) -> std::optional<scxml::Symbol> {
    if (name.size() != 2 || name[0] != 's' || name[1] < '0' || name[1] > '3') return std::nullopt;
    const auto type = name[1] == '0' ? scxml::Type::kFlag : scxml::Type::kNumber;
    return scxml::Symbol{scxml::SymbolKind::kSignal, type, name[1] - '0'};
  };
  vocabulary.suggest_signal = [](const std::string&) { return std::string("s0"); };
  vocabulary.is_parameter = [](const std::string& name) { return name == "p"; };
  vocabulary.suggest_parameter = [](const std::string&) { return std::string("p"); };
  vocabulary.find_lamp = [](const std::string& name) {
    return name == "l" ? std::optional<int>(0) : std::optional<int>();
  };
  vocabulary.suggest_lamp = [](const std::string&) { return std::string("l"); };
  return vocabulary;
}

class CountingHost : public scxml::Host {
 public:
  void OnEnter(int, std::int64_t) override { ++num_calls; }
  void OnExit(int, const scxml::Transition&, std::int64_t) override { ++num_calls; }
  void OnAction(const scxml::Action&, double) override { ++num_calls; }
  std::uint64_t num_calls = 0;
};

}  // namespace

// The input as a procedure. If accepted, it runs ten steps with changing signals.
void FuzzProcedure(Input input) {
  static const ScratchFolder folder;
  static const scxml::Vocabulary vocabulary = MakeVocabulary();
  const auto chart = scxml::LoadChart(folder.Write("procedure.scxml", input), vocabulary);
  if (!chart) {
    Claim(!chart.error().empty(), "a refusal says why");
    return;
  }
  (void)scxml::AnalyseChart(*chart);
  CountingHost host;
  scxml::Interpreter interpreter(*chart, &host);
  std::vector<double> signals{0.0, 0.0, 1.0, -2.5};
  interpreter.Start(0, &signals);
  for (int step = 1; step <= 10 && interpreter.is_running(); ++step) {
    signals[0] = step % 2;
    signals[1] = step;
    interpreter.Advance(step * std::int64_t{100'000'000}, {"e", "done.state.a", "x.y"});
    for (const scxml::Transition& transition : chart->transitions) {
      (void)transition.condition.DescribeUnmet(interpreter.environment());
    }
    Claim(!interpreter.is_running() || !interpreter.Configuration().empty(), "a running chart has an active state");
  }
}

}  // namespace fuzz
