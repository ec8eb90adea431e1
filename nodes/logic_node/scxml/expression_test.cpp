#include "nodes/logic_node/scxml/expression.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace logic_node::scxml {
namespace {

using testing::HasSubstr;

const std::vector<double> kSignals{0.0, 0.25, 1.0, 3.0};
const std::vector<double> kVariables{7.0};
const std::vector<char> kStates{0, 1};

Scope MakeScope() {
  Scope scope;
  scope.find_symbol = [](const std::string& name) -> std::optional<Symbol> {
    if (name == "latch_a.state") return Symbol{SymbolKind::kSignal, Type::kNumber, 0};
    if (name == "block.x") return Symbol{SymbolKind::kSignal, Type::kNumber, 1};
    if (name == "op1/arm.left.grasped.tool") return Symbol{SymbolKind::kSignal, Type::kFlag, 2};
    if (name == "op1") return Symbol{SymbolKind::kSignal, Type::kNumber, 3};
    if (name == "count") return Symbol{SymbolKind::kVariable, Type::kNumber, 0};
    return std::nullopt;
  };
  scope.find_state = [](const std::string& id) -> std::optional<int> {
    return id == "on" ? std::optional<int>(1) : id == "off" ? std::optional<int>(0) : std::nullopt;
  };
  return scope;
}

Environment MakeEnvironment() {
  return {&kSignals, &kVariables, &kStates};
}

double Value(const std::string& text) {
  const auto expression = Expression::Compile(text, MakeScope());
  EXPECT_TRUE(expression) << text << ": " << (expression ? "" : expression.error().what);
  return expression ? expression->Evaluate(MakeEnvironment()) : -999.0;
}

std::string Complaint(const std::string& text) {
  const auto expression = Expression::Compile(text, MakeScope());
  return expression ? "" : expression.error().what + ": " + expression.error().why + ". " + expression.error().fix;
}

TEST(Expression, OperatorsHaveThePrecedenceOfC) {
  EXPECT_EQ(Value("1 + 2 * 3"), 7.0);
  EXPECT_EQ(Value("(1 + 2) * 3"), 9.0);
  EXPECT_EQ(Value("10 - 4 - 3"), 3.0);
  EXPECT_EQ(Value("16 / 4 / 2"), 2.0);
  EXPECT_EQ(Value("-2 * -3"), 6.0);
  EXPECT_EQ(Value("--2"), 2.0);
  EXPECT_EQ(Value("1 - -1"), 2.0);
  EXPECT_EQ(Value("2 < 3 == true"), 1.0);
  EXPECT_EQ(Value("true || false && false"), 1.0);
  EXPECT_EQ(Value("!true || true"), 1.0);
  EXPECT_EQ(Value("!(true || true)"), 0.0);
  EXPECT_EQ(Value("1e-3*1.5E3"), 1.5);
  EXPECT_EQ(Value("1<=1 && 1>=1 && !(1<1) && 1!=2"), 1.0);
}

TEST(Expression, ReadsSignalsVariablesAndStates) {
  EXPECT_EQ(Value("latch_a.state"), 0.0);
  EXPECT_EQ(Value("block.x * 4 + count"), 8.0);
  EXPECT_EQ(Value("In('on') && !In(\"off\")"), 1.0);
}

TEST(Expression, PrefersTheLongestKnownNameToOperators) {
  EXPECT_EQ(Value("op1/arm.left.grasped.tool"), 1.0);
  EXPECT_EQ(Value("op1/count"), 3.0 / 7.0);
  EXPECT_EQ(Value("op1/2"), 1.5);
  EXPECT_EQ(Value("count-op1"), 4.0);
}

TEST(Expression, AFlagIsANumberAndABoolean) {
  EXPECT_EQ(Value("op1/arm.left.grasped.tool == 1"), 1.0);
  EXPECT_EQ(Value("op1/arm.left.grasped.tool && true"), 1.0);
  EXPECT_EQ(Value("op1/arm.left.grasped.tool == true"), 1.0);
}

TEST(Expression, RefusesTypeErrorsUnknownNamesAndBrokenSyntax) {
  EXPECT_THAT(Complaint("latch_a.state && true"), HasSubstr("'latch_a.state' is a number"));
  EXPECT_THAT(Complaint("latch_a.state && true"), HasSubstr("latch_a.state == 1"));
  EXPECT_THAT(Complaint("(1 < 2) + 1"), HasSubstr("is a boolean"));
  EXPECT_THAT(Complaint("1 == true"), HasSubstr("is a"));
  EXPECT_THAT(Complaint("latch_a.state = 1"), HasSubstr("write == to compare"));
  EXPECT_THAT(Complaint("latch_b.state == 1"), HasSubstr("unknown name 'latch_b.state'"));
  EXPECT_THAT(Complaint("In('gone')"), HasSubstr("no such state"));
  EXPECT_THAT(Complaint("5mm"), HasSubstr("SI"));
  EXPECT_THAT(Complaint("!1"), HasSubstr("is a number"));
  for (const char* broken :
       {"", " ", "1 +", "(1", "1)", "* 2", "1 2", "In(", "In('on'", "In(on)", "&", "'a'", "1..2"}) {
    EXPECT_NE(Complaint(broken), "") << broken;
  }
}

TEST(Expression, RefusesDeepNesting) {
  EXPECT_NE(Complaint(std::string(100000, '(')), "");
  EXPECT_NE(Complaint(std::string(100000, '!') + "true"), "");
}

TEST(Expression, RandomTextIsCompiledOrRefusedWithAReason) {
  const std::string alphabet = "01.e+-*/()<>=!&| InCount'op1/latch_a.state\"";
  std::mt19937_64 random(3);
  int num_compiled = 0;
  for (int run = 0; run < 20000; ++run) {
    std::string text;
    for (std::uint64_t i = random() % 12; i > 0; --i) text += alphabet[random() % alphabet.size()];
    const auto expression = Expression::Compile(text, MakeScope());
    if (expression) {
      ++num_compiled;
      const bool is_met = expression->IsTrue(MakeEnvironment());
      if (is_met) {
        EXPECT_EQ(expression->DescribeUnmet(MakeEnvironment()), "") << text;
      }
    } else {
      EXPECT_FALSE(expression.error().what.empty() || expression.error().fix.empty()) << text;
    }
  }
  EXPECT_GT(num_compiled, 50);
}

TEST(Expression, DescribesUnmetConditions) {
  const auto unmet = [](const char* text) {
    return Expression::Compile(text, MakeScope())->DescribeUnmet(MakeEnvironment());
  };
  EXPECT_EQ(unmet("latch_a.state == 1"), "latch_a.state == 1, which is 0");
  EXPECT_EQ(unmet("count == 7 && latch_a.state == 1"), "latch_a.state == 1, which is 0");
  EXPECT_EQ(unmet("count == 7"), "");
  EXPECT_EQ(unmet("block.x > count"), "block.x > count, where block.x is 0.25, count is 7");
  EXPECT_EQ(unmet("In('off') && block.x * block.x < 0.01"),
            "In('off'), which is not so and block.x * block.x < 0.01, which is 0.25");
}

TEST(Expression, FindsConstantExpressions) {
  EXPECT_EQ(Expression::Compile("1 == 2", MakeScope())->ConstantValue(), 0.0);
  EXPECT_EQ(Expression::Compile("count == 2", MakeScope())->ConstantValue(), std::nullopt);
}

// Evaluation recurses once for each operator of a chain.
TEST(Expression, RefusesAChainOfMoreThan1000Nodes) {
  std::string text = "1";
  for (int i = 0; i < 400; ++i) text += " + 1";
  EXPECT_EQ(Expression::Compile(text, MakeScope())->ConstantValue(), 401.0);
  for (int i = 0; i < 400; ++i) text += " + 1";
  const auto refused = Expression::Compile(text, MakeScope());
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().what, "the expression is too long");
}

}  // namespace
}  // namespace logic_node::scxml
