#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace logic_node::scxml {

// Typed expressions of a procedure: numbers, booleans, signals, variables, In('state'), parentheses and the operators
// && || ! == != < <= > >= + - * /. Types are checked at compile time, so evaluation cannot fail.

// kFlag is a signal that is 0 or 1: it is accepted as a number and as a boolean.
enum class Type { kNumber, kBoolean, kFlag };

enum class SymbolKind { kSignal, kVariable };

struct Symbol {
  SymbolKind kind = SymbolKind::kSignal;
  Type type = Type::kNumber;
  int slot = 0;  // into Environment::signals or Environment::variables
};

// Meaning of names at compile time.
struct Scope {
  std::function<std::optional<Symbol>(const std::string& name)> find_symbol;
  std::function<std::optional<int>(const std::string& id)> find_state;
  std::function<std::string(const std::string& name)> suggest;  // remedy for an unknown name
};

// Values of names at evaluation.
struct Environment {
  const std::vector<double>* signals = nullptr;
  const std::vector<double>* variables = nullptr;
  const std::vector<char>* active_states = nullptr;
};

struct ExpressionError {
  std::size_t position = 0;  // character in the text
  std::string what;
  std::string why;
  std::string fix;
};

class Expression {
 public:
  // A constant number or boolean.
  static Expression Constant(double value);
  static tl::expected<Expression, ExpressionError> Compile(std::string_view text, const Scope& scope);

  [[nodiscard]] Type type() const { return nodes_.empty() ? Type::kBoolean : nodes_[root()].type; }
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] bool empty() const { return nodes_.empty(); }

  // Booleans are 1 and 0. An empty expression is true: a transition without condition.
  [[nodiscard]] double Evaluate(const Environment& environment) const;
  [[nodiscard]] bool IsTrue(const Environment& environment) const { return Evaluate(environment) != 0.0; }

  // The value if it depends on no signal, variable or state.
  [[nodiscard]] std::optional<double> ConstantValue() const;

  // Describes the false parts of a conjunction with the values of their names: "latch_a.state == 1, which is 0". Empty
  // when all are true.
  [[nodiscard]] std::string DescribeUnmet(const Environment& environment) const;

 private:
  friend class Parser;
  enum class Op {
    kConstant,
    kSignal,
    kVariable,
    kIn,
    kNot,
    kNegate,
    kOr,
    kAnd,
    kEqual,
    kNotEqual,
    kLess,
    kLessEqual,
    kGreater,
    kGreaterEqual,
    kAdd,
    kSubtract,
    kMultiply,
    kDivide
  };
  struct Node {
    Op op = Op::kConstant;
    Type type = Type::kNumber;
    double value = 0.0;
    int slot = 0;  // signal, variable or state
    int left = -1;
    int right = -1;
    std::size_t begin = 0;  // of its text
    std::size_t end = 0;
  };

  // The root is built last.
  [[nodiscard]] std::size_t root() const { return nodes_.size() - 1; }
  [[nodiscard]] double EvaluateNode(int index, const Environment& environment) const;
  void CollectUnmet(int index, const Environment& environment, std::vector<std::string>* unmet) const;
  void CollectSymbols(int index, std::vector<int>* symbols) const;
  [[nodiscard]] std::string TextOf(const Node& node) const { return text_.substr(node.begin, node.end - node.begin); }

  std::string text_;
  std::vector<Node> nodes_;
};

// Formats a number for messages: six significant digits, no trailing zeros.
std::string FormatNumber(double value);

}  // namespace logic_node::scxml
