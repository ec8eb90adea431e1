#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "replay/step_codec.hpp"

namespace replay {

// Digest of the outputs of a step: equal bits in the same order of fields give equal digests.
class Digest {
 public:
  static constexpr bool kReads = false;
  template <class T>
  void Value(std::string_view, T& value) {
    Add(BitsOf(value));
  }
  void Text(std::string_view, std::string& text);
  std::size_t Count(std::string_view, std::size_t count) {
    Add(count);
    return count;
  }
  void Enter(std::string_view) {}
  void Enter(std::string_view, std::size_t) {}
  void Leave() {}
  // Multiply and fold: a step's thousand fields take a microsecond.
  void Add(std::uint64_t bits) {
    value_ = (value_ ^ bits) * 0x9e37'79b9'7f4a'7c15ULL;
    value_ ^= value_ >> 32;
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

  bool includes_transport = true;

 private:
  std::uint64_t value_ = 0x5eed'0f57'e9d1'6e57ULL;
};

// A field with its name, e.g. "state.bodies[3].X_WO.translation.x".
struct Leaf {
  enum class Kind : std::uint8_t { kReal, kSigned, kUnsigned, kText };
  std::string path;
  Kind kind = Kind::kReal;
  double number = 0.0;     // of a text: not a number
  std::uint64_t bits = 0;  // of a text: its hash
  std::string text;        // of a text
};

// Collects all fields with their names, for comparison and reports. Not real-time.
class Leaves {
 public:
  static constexpr bool kReads = false;
  template <class T>
  void Value(std::string_view name, T& value) {
    constexpr Leaf::Kind kKind = std::is_floating_point_v<T> ? Leaf::Kind::kReal
                                 : std::is_signed_v<T>       ? Leaf::Kind::kSigned
                                                             : Leaf::Kind::kUnsigned;
    leaves_.push_back({PathOf(name), kKind, static_cast<double>(value), BitsOf(value), {}});
  }
  void Text(std::string_view name, std::string& text);
  std::size_t Count(std::string_view name, std::size_t count);
  void Enter(std::string_view name);
  void Enter(std::string_view name, std::size_t index);
  void Leave();
  [[nodiscard]] const std::vector<Leaf>& all() const { return leaves_; }

  bool includes_transport = true;

 private:
  [[nodiscard]] std::string PathOf(std::string_view name) const;

  std::string path_;
  std::vector<std::size_t> lengths_;  // of the path, by level
  std::vector<Leaf> leaves_;
};

// Tolerances by names of fields. A line of the file is
//     PATTERN abs=1e-9 rel=1e-6      or      PATTERN ignore
// where '*' in PATTERN stands for any text; '#' begins a comment. The first line that matches counts; a field without
// one must be equal bit for bit. A number is within when |got - expected| <= abs + rel |expected|.
class Tolerance {
 public:
  static core::Result<Tolerance> Parse(const std::string& text, const std::string& file);
  static core::Result<Tolerance> Read(const std::string& file);
  [[nodiscard]] bool IsWithin(const std::string& name, const Leaf& expected, const Leaf& got) const;
  [[nodiscard]] bool Ignores(const std::string& name) const;
  [[nodiscard]] bool is_exact() const { return rules_.empty(); }

 private:
  struct Rule {
    std::string pattern;
    double absolute = 0.0, relative = 0.0;
    bool is_ignored = false;
  };
  [[nodiscard]] const Rule* Find(const std::string& name) const;
  std::vector<Rule> rules_;
};

struct FieldDifference {
  std::string path;
  std::string expected, got;
  double distance = 0.0;  // of numbers; infinite when one is missing, is a text, or is not finite
};

// In the order of the expected fields; `name_of` turns a path into the name that the tolerance knows.
template <class NameOf>
std::vector<FieldDifference> Compare(const std::vector<Leaf>& expected, const std::vector<Leaf>& got,
                                     const Tolerance& tolerance, NameOf&& name_of);

FieldDifference DifferenceOf(const Leaf* expected, const Leaf* got);

template <class NameOf>
std::vector<FieldDifference> Compare(const std::vector<Leaf>& expected, const std::vector<Leaf>& got,
                                     const Tolerance& tolerance, NameOf&& name_of) {
  std::vector<FieldDifference> differences;
  const auto compare = [&](const Leaf& leaf, const Leaf* other) {
    if (other != nullptr && other->bits == leaf.bits) return;
    const std::string name = name_of(leaf.path);
    if (other == nullptr ? !tolerance.Ignores(name) : !tolerance.IsWithin(name, leaf, *other)) {
      differences.push_back(DifferenceOf(&leaf, other));
    }
  };
  // Usually both have the same fields.
  if (std::equal(expected.begin(), expected.end(), got.begin(), got.end(),
                 [](const Leaf& a, const Leaf& b) { return a.path == b.path; })) {
    for (std::size_t i = 0; i < expected.size(); ++i) compare(expected[i], &got[i]);
    return differences;
  }
  std::map<std::string_view, const Leaf*> left;
  for (const Leaf& leaf : got) left.emplace(leaf.path, &leaf);
  for (const Leaf& leaf : expected) {
    const auto found = left.find(leaf.path);
    const Leaf* other = found == left.end() ? nullptr : found->second;
    if (other != nullptr) left.erase(found);
    compare(leaf, other);
  }
  for (const auto& [path, leaf] : left) {
    if (!tolerance.Ignores(name_of(leaf->path))) differences.push_back(DifferenceOf(nullptr, leaf));
  }
  return differences;
}

}  // namespace replay
