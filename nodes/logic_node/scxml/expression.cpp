#include "nodes/logic_node/scxml/expression.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>

namespace logic_node::scxml {

std::string FormatNumber(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof(buffer), "%.6g", value);
  return buffer;
}

Expression Expression::Constant(double value) {
  Expression expression;
  expression.text_ = FormatNumber(value);
  Node node;
  node.value = value;
  node.end = expression.text_.size();
  expression.nodes_.push_back(node);
  return expression;
}

double Expression::Evaluate(const Environment& environment) const {
  return nodes_.empty() ? 1.0 : EvaluateNode(static_cast<int>(root()), environment);
}

double Expression::EvaluateNode(int index, const Environment& environment) const {
  const Node& node = nodes_[static_cast<std::size_t>(index)];
  const auto slot = static_cast<std::size_t>(node.slot);
  const auto left = [&] { return EvaluateNode(node.left, environment); };
  const auto right = [&] { return EvaluateNode(node.right, environment); };
  switch (node.op) {
    case Op::kConstant:
      return node.value;
    case Op::kSignal:
      return (*environment.signals)[slot];
    case Op::kVariable:
      return (*environment.variables)[slot];
    case Op::kIn:
      return (*environment.active_states)[slot] != 0 ? 1.0 : 0.0;
    case Op::kNot:
      return left() == 0.0 ? 1.0 : 0.0;
    case Op::kNegate:
      return -left();
    case Op::kOr:
      return left() != 0.0 || right() != 0.0 ? 1.0 : 0.0;
    case Op::kAnd:
      return left() != 0.0 && right() != 0.0 ? 1.0 : 0.0;
    case Op::kEqual:
      return left() == right() ? 1.0 : 0.0;
    case Op::kNotEqual:
      return left() != right() ? 1.0 : 0.0;
    case Op::kLess:
      return left() < right() ? 1.0 : 0.0;
    case Op::kLessEqual:
      return left() <= right() ? 1.0 : 0.0;
    case Op::kGreater:
      return left() > right() ? 1.0 : 0.0;
    case Op::kGreaterEqual:
      return left() >= right() ? 1.0 : 0.0;
    case Op::kAdd:
      return left() + right();
    case Op::kSubtract:
      return left() - right();
    case Op::kMultiply:
      return left() * right();
    case Op::kDivide:
      return left() / right();
  }
  return 0.0;
}

std::optional<double> Expression::ConstantValue() const {
  for (const Node& node : nodes_) {
    if (node.op == Op::kSignal || node.op == Op::kVariable || node.op == Op::kIn) return std::nullopt;
  }
  return Evaluate({});
}

std::string Expression::DescribeUnmet(const Environment& environment) const {
  std::vector<std::string> unmet;
  if (!nodes_.empty()) CollectUnmet(static_cast<int>(root()), environment, &unmet);
  std::string text;
  for (std::size_t i = 0; i < unmet.size(); ++i) text += (i > 0 ? " and " : "") + unmet[i];
  return text;
}

void Expression::CollectUnmet(int index, const Environment& environment, std::vector<std::string>* unmet) const {
  const Node& node = nodes_[static_cast<std::size_t>(index)];
  if (node.op == Op::kAnd) {
    CollectUnmet(node.left, environment, unmet);
    CollectUnmet(node.right, environment, unmet);
    return;
  }
  if (EvaluateNode(index, environment) != 0.0) return;
  std::vector<int> symbols;
  CollectSymbols(index, &symbols);
  std::string text = TextOf(node);
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    const Node& symbol = nodes_[static_cast<std::size_t>(symbols[i])];
    const std::string value = symbol.op == Op::kIn ? "not so" : FormatNumber(EvaluateNode(symbols[i], environment));
    text += symbols.size() == 1 ? ", which is " + value : (i > 0 ? ", " : ", where ") + TextOf(symbol) + " is " + value;
  }
  unmet->push_back(text);
}

void Expression::CollectSymbols(int index, std::vector<int>* symbols) const {
  if (index < 0) return;
  const Node& node = nodes_[static_cast<std::size_t>(index)];
  if (node.op == Op::kSignal || node.op == Op::kVariable || node.op == Op::kIn) {
    const bool is_known = std::any_of(symbols->begin(), symbols->end(), [&](int other) {
      return TextOf(nodes_[static_cast<std::size_t>(other)]) == TextOf(node);
    });
    if (!is_known) symbols->push_back(index);
    return;
  }
  CollectSymbols(node.left, symbols);
  CollectSymbols(node.right, symbols);
}

// Recursive descent, loosest binding first: || && (== !=) (< <= > >=) (+ -) (* /) unary primary.
class Parser {
 public:
  Parser(std::string_view text, const Scope& scope) : text_(text), scope_(scope) { expression_.text_ = text; }

  tl::expected<Expression, ExpressionError> Run() {
    const int parsed = ParseLevel(0);
    if (parsed >= 0) {
      SkipBlanks();
      if (at_ < text_.size()) {
        const bool is_assignment = text_[at_] == '=';
        Fail("unexpected '" + std::string(text_.substr(at_, 10)) + "'",
             is_assignment ? "'=' does not compare" : "the expression ended before it",
             is_assignment ? "write == to compare" : "add an operator or remove it");
      }
    }
    if (error_) return tl::unexpected(*error_);
    return std::move(expression_);
  }

 private:
  using Op = Expression::Op;
  using Node = Expression::Node;
  struct Operator {
    std::string_view sign;
    Op op;
    int level;
  };
  // Longer signs first, so that "<=" is not read as "<".
  static constexpr Operator kOperators[] = {
      {"||", Op::kOr, 0},        {"&&", Op::kAnd, 1},          {"==", Op::kEqual, 2},   {"!=", Op::kNotEqual, 2},
      {"<=", Op::kLessEqual, 3}, {">=", Op::kGreaterEqual, 3}, {"<", Op::kLess, 3},     {">", Op::kGreater, 3},
      {"+", Op::kAdd, 4},        {"-", Op::kSubtract, 4},      {"*", Op::kMultiply, 5}, {"/", Op::kDivide, 5}};
  static constexpr int kUnaryLevel = 6;
  // Parsing and evaluation recurse; these limits bound the stack, far above any expression in use.
  static constexpr int kMaxDepth = 64;
  static constexpr std::size_t kMaxNodes = 1000;

  static bool IsLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
  static bool IsDigit(char c) { return c >= '0' && c <= '9'; }
  static bool IsWord(char c) { return IsLetter(c) || IsDigit(c) || c == '.'; }

  void SkipBlanks() {
    while (at_ < text_.size() &&
           (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r')) {
      ++at_;
    }
  }

  int Fail(std::string what, std::string why, std::string fix) {
    if (!error_) error_ = ExpressionError{at_, std::move(what), std::move(why), std::move(fix)};
    return -1;
  }

  int Add(const Node& node) {
    expression_.nodes_.push_back(node);
    return static_cast<int>(expression_.nodes_.size() - 1);
  }
  const Node& At(int index) const { return expression_.nodes_[static_cast<std::size_t>(index)]; }

  const Operator* PeekOperator(int level) {
    SkipBlanks();
    for (const Operator& candidate : kOperators) {
      if (text_.substr(at_, candidate.sign.size()) != candidate.sign) continue;
      return candidate.level == level ? &candidate : nullptr;
    }
    return nullptr;
  }

  int ParseLevel(int level) {
    if (level == kUnaryLevel) return ParseUnary();
    int left = ParseLevel(level + 1);
    while (left >= 0) {
      const Operator* found = PeekOperator(level);
      if (found == nullptr) return left;
      at_ += found->sign.size();
      const int right = ParseLevel(level + 1);
      if (right < 0) return -1;
      left = Combine(*found, left, right);
      if (left >= 0 && expression_.nodes_.size() > kMaxNodes) {
        return Fail("the expression is too long", "1000 values and operators are allowed", "divide it");
      }
    }
    return left;
  }

  static std::string Quoted(std::string_view text) {
    std::string quoted(1, '\'');
    return quoted.append(text).append(1, '\'');
  }

  bool RequireType(int index, Type type, std::string_view sign) {
    const Type given = At(index).type;
    if (given == type || given == Type::kFlag) return true;
    const std::string part = expression_.TextOf(At(index));
    if (type == Type::kBoolean) {
      Fail("'" + part + "' is a number", Quoted(sign) + " needs booleans", "compare it, as in " + part + " == 1");
    } else {
      Fail("'" + part + "' is a boolean", Quoted(sign) + " needs numbers", "use its parts instead");
    }
    return false;
  }

  int Combine(const Operator& found, int left, int right) {
    Node node;
    node.op = found.op;
    node.left = left;
    node.right = right;
    node.begin = At(left).begin;
    node.end = At(right).end;
    node.type = found.level >= 4 ? Type::kNumber : Type::kBoolean;
    if (found.level == 2) {
      // Equality compares operands of the same type; a flag is of both types.
      const Type type = At(left).type == Type::kFlag ? At(right).type : At(left).type;
      if (type != Type::kFlag && (!RequireType(left, type, found.sign) || !RequireType(right, type, found.sign)))
        return -1;
    } else {
      const Type type = found.level < 2 ? Type::kBoolean : Type::kNumber;
      if (!RequireType(left, type, found.sign) || !RequireType(right, type, found.sign)) return -1;
    }
    return Add(node);
  }

  int ParseUnary() {
    SkipBlanks();
    if (++depth_ > kMaxDepth)
      return Fail("the expression is nested too deeply", "64 levels are allowed", "simplify it");
    const std::size_t begin = at_;
    int result = -1;
    const char c = at_ < text_.size() ? text_[at_] : '\0';
    if (c == '!' || c == '-') {
      ++at_;
      const int operand = ParseUnary();
      if (operand >= 0 && RequireType(operand, c == '!' ? Type::kBoolean : Type::kNumber, std::string_view(&c, 1))) {
        Node node;
        node.op = c == '!' ? Op::kNot : Op::kNegate;
        node.type = c == '!' ? Type::kBoolean : Type::kNumber;
        node.left = operand;
        node.begin = begin;
        node.end = At(operand).end;
        result = Add(node);
      }
    } else {
      result = ParsePrimary();
    }
    --depth_;
    return result;
  }

  int ParsePrimary() {
    if (at_ >= text_.size()) {
      return Fail("the expression ends too early", "a value is missing", "add a number or a signal's name");
    }
    const char c = text_[at_];
    if (c == '(') {
      const std::size_t begin = at_++;
      const int inner = ParseLevel(0);
      if (inner < 0) return -1;
      SkipBlanks();
      if (at_ >= text_.size() || text_[at_] != ')') return Fail("')' is missing", "'(' was opened", "add ')'");
      ++at_;
      Node& node = expression_.nodes_[static_cast<std::size_t>(inner)];
      node.begin = begin;
      node.end = at_;
      return inner;
    }
    if (IsDigit(c) || c == '.') return ParseNumber();
    if (IsLetter(c)) return ParseWord();
    return Fail("unexpected '" + std::string(1, c) + "'", "a value should stand here",
                "add a number or a signal's name");
  }

  int ParseNumber() {
    Node node;
    node.begin = at_;
    const auto [end, status] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), node.value);
    if (status != std::errc()) {
      return Fail("not a number", "a number has digits, a point and an exponent", "correct it");
    }
    at_ = static_cast<std::size_t>(end - text_.data());
    if (at_ < text_.size() && IsLetter(text_[at_])) {
      return Fail("a unit or name stands right after " + std::string(text_.substr(node.begin, at_ - node.begin)),
                  "all numbers are SI, without units", "convert it and remove the letters");
    }
    node.end = at_;
    return Add(node);
  }

  int ParseWord() {
    // Names of roles may contain '/' and '-', which are operators too: take the longest known name.
    std::size_t end = at_;
    while (end < text_.size() && (IsWord(text_[end]) || text_[end] == '/' || text_[end] == '-')) ++end;
    std::size_t short_end = at_;
    while (short_end < text_.size() && IsWord(text_[short_end])) ++short_end;
    for (std::size_t cut = end; cut >= short_end; --cut) {
      if (cut < end && text_[cut] != '/' && text_[cut] != '-') continue;
      const std::string name(text_.substr(at_, cut - at_));
      if (const auto symbol = scope_.find_symbol ? scope_.find_symbol(name) : std::nullopt) {
        Node node;
        node.op = symbol->kind == SymbolKind::kSignal ? Op::kSignal : Op::kVariable;
        node.type = symbol->type;
        node.slot = symbol->slot;
        node.begin = at_;
        node.end = at_ = cut;
        return Add(node);
      }
    }
    const std::string word(text_.substr(at_, short_end - at_));
    if (word == "true" || word == "false") {
      Node node;
      node.type = Type::kBoolean;
      node.value = word == "true" ? 1.0 : 0.0;
      node.begin = at_;
      node.end = at_ = short_end;
      return Add(node);
    }
    if (word == "In") return ParseIn(short_end);
    const std::string fix = scope_.suggest ? scope_.suggest(word) : "use a known name";
    return Fail("unknown name '" + word + "'", "it is neither a signal of this scenario nor a <data>", fix);
  }

  int ParseIn(std::size_t after) {
    Node node;
    node.op = Op::kIn;
    node.type = Type::kBoolean;
    node.begin = at_;
    at_ = after;
    SkipBlanks();
    const std::size_t open = at_;
    const std::size_t first = text_.find_first_of("'\"", open);
    const std::size_t second = first == std::string_view::npos ? first : text_.find(text_[first], first + 1);
    const std::size_t close = second == std::string_view::npos ? second : text_.find(')', second);
    if (open >= text_.size() || text_[open] != '(' || close == std::string_view::npos) {
      return Fail("In without a state", "In('id') is true while the state id is active", "write In('id')");
    }
    const std::string id(text_.substr(first + 1, second - first - 1));
    const auto state = scope_.find_state ? scope_.find_state(id) : std::nullopt;
    if (!state) return Fail("In('" + id + "'): no such state", "it must name a state of this file", "correct the id");
    node.slot = *state;
    node.end = at_ = close + 1;
    return Add(node);
  }

  std::string_view text_;
  const Scope& scope_;
  std::size_t at_ = 0;
  int depth_ = 0;
  Expression expression_;
  std::optional<ExpressionError> error_;
};

tl::expected<Expression, ExpressionError> Expression::Compile(std::string_view text, const Scope& scope) {
  return Parser(text, scope).Run();
}

}  // namespace logic_node::scxml
