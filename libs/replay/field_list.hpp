#pragma once

#include <string>
#include <string_view>
#include <type_traits>

#include "replay/fields.hpp"

namespace replay {

// The names and types of all fields of a step, one a line, with one item in every list. A recording stores it: only a
// build with the same list can read its steps.
class FieldList {
 public:
  static constexpr bool kReads = true;
  template <class T>
  void Value(std::string_view name, T&) {
    Add(name, std::is_floating_point_v<T> ? 'f' : std::is_signed_v<T> ? 'i' : 'u', sizeof(T));
  }
  void Text(std::string_view name, std::string&) { Add(name, 's', 1); }
  std::size_t Count(std::string_view name, std::size_t) {
    Add(name, 'n', sizeof(std::uint64_t));
    return 1;
  }
  void Enter(std::string_view name) {
    lengths_.push_back(path_.size());
    if (!path_.empty()) path_ += '.';
    path_ += name;
  }
  void Enter(std::string_view name, std::size_t) {
    Enter(name);
    path_ += "[]";
  }
  void Leave() {
    path_.resize(lengths_.back());
    lengths_.pop_back();
  }
  void Fail() {}
  [[nodiscard]] const std::string& text() const { return text_; }

  bool includes_transport = true;

 private:
  void Add(std::string_view name, char kind, std::size_t size) {
    text_ += path_;
    if (!path_.empty() && !name.empty()) text_ += '.';
    text_ += name;
    text_ += ' ';
    text_ += kind;
    text_ += std::to_string(8 * size) + '\n';
  }

  std::string path_, text_;
  std::vector<std::size_t> lengths_;
};

template <class Step>
std::string DescribeFields() {
  Step step;
  FieldList list;
  VisitInputs(list, step);
  list.includes_transport = false;
  VisitOutputs(list, step);
  return list.text();
}

}  // namespace replay
