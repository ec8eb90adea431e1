// The only file that sees CLI11, which takes seconds to compile.

#include "cli/arguments.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cctype>
#include <memory>

#include "cli/read_number.hpp"
#include "core/names.hpp"

namespace cli {
namespace {

class HelpFormatter : public CLI::Formatter {
 public:
  explicit HelpFormatter(const Syntax& syntax) : syntax_(syntax) { column_width(28); }

  std::string make_usage(const CLI::App* /*app*/, std::string name) const override {
    std::string usage = "usage: " + name;
    if (!syntax_.positional.empty()) usage += " " + std::string(syntax_.positional);
    return usage + (syntax_.options.empty() ? "" : " [options]") + "\n";
  }
  std::string make_option_opts(const CLI::Option* option) const override {
    return option->get_type_name().empty() ? "" : " " + option->get_type_name();
  }

 private:
  const Syntax& syntax_;
};

std::string HelpOf(const Option& option) {
  std::string text(option.help);
  const std::string range = Describe(option.range);
  if (!range.empty() && option.range.words != option.value_name) text += "; " + range;
  if (!option.fallback.empty()) text += "; default: " + std::string(option.fallback);
  if (option.is_required) text += "; required";
  return text;
}

std::unique_ptr<CLI::App> MakeApp(const Syntax& syntax) {
  auto app = std::make_unique<CLI::App>(std::string(syntax.summary), syntax.program);
  app->set_help_flag();  // ours, below: it must not end the program
  app->allow_extras();   // positional words and unknown options; Parse sorts them
  for (const Option& option : syntax.options) {
    const std::string name(option.name);
    const std::string help = HelpOf(option);
    if (option.value_name.empty()) {
      app->add_flag(name, help)->disable_flag_override();
      continue;
    }
    CLI::Option* added = app->add_option(name, CLI::callback_t([](const CLI::results_t&) { return true; }), help);
    added->type_name(std::string(option.value_name))->type_size(1)->expected(1);
    added->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)->allow_extra_args(false);
  }
  const std::string help_of_help = "prints this";
  app->add_flag("-h,--help", help_of_help);
  app->formatter(std::make_shared<HelpFormatter>(syntax));
  return app;
}

tl::unexpected<core::Error> Refuse(const std::string& why) {
  return core::Fail(core::ErrorCode::kInvalidInput, why);
}

// CLI11 names the option first, with or without its dashes, and then what is wrong in its own words.
std::string Reword(const CLI::ParseError& error, const Syntax& syntax) {
  const std::string message = error.what();
  const std::size_t begin = std::min(message.find_first_not_of('-'), message.size());
  const std::string named = "--" + message.substr(begin, message.find_first_of(": ", begin) - begin);
  for (const Option& option : syntax.options) {
    if (option.name != named) continue;
    return named +
           (option.value_name.empty() ? " takes no value" : " needs a value: " + std::string(option.value_name));
  }
  return message;
}

bool IsUnknownOption(const std::string& word) {
  if (word.rfind("--", 0) == 0) return true;
  // A negative number is a word like any other.
  return word.size() > 1 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1])) != 0;
}

std::string DescribeUnknown(const std::string& word, const Syntax& syntax) {
  const std::string name = word.substr(0, word.find('='));
  std::vector<std::string> known;
  for (const Option& option : syntax.options) known.emplace_back(option.name);
  const std::string nearest = core::NearestName(name, known);
  std::string text = "unknown option " + name;
  if (!nearest.empty()) return text + "; did you mean " + nearest + "?";
  if (known.empty()) return text + "; " + syntax.program + " takes none";
  text += "; known:";
  for (const std::string& one : known) text += " " + one;
  return text;
}

std::string Wanted(const Option& option, const std::string& value) {
  return std::string(option.name) + " needs " + Describe(option.range) + ", not '" + value + "'";
}

}  // namespace

core::Result<Arguments> Arguments::Parse(const std::vector<std::string>& words, const Syntax& syntax) {
  const std::unique_ptr<CLI::App> app = MakeApp(syntax);
  try {
    app->parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::ParseError& error) {
    return Refuse(Reword(error, syntax));
  }
  Arguments arguments;
  if (app->count("--help") > 0) {
    arguments.wants_help_ = true;
    return arguments;
  }
  bool only_positional = false;
  for (const std::string& word : app->remaining()) {
    if (!only_positional && word == "--") {
      only_positional = true;
    } else if (!only_positional && IsUnknownOption(word)) {
      return Refuse(DescribeUnknown(word, syntax));
    } else {
      arguments.positional_.push_back(word);
    }
  }
  for (const Option& option : syntax.options) {
    const std::string name(option.name);
    if (!option.fallback.empty()) arguments.fallbacks_[name] = option.fallback;
    const std::size_t times = app->count(name);
    if (times == 0 && option.is_required) return Refuse(name + " " + std::string(option.value_name) + " is missing");
    if (times == 0) continue;
    std::vector<std::string>& values = arguments.given_[name];
    values = option.value_name.empty() ? std::vector<std::string>(times) : app->get_option(name)->results();
    for (const std::string& value : values) {
      if (!Contains(option.range, value)) return Refuse(Wanted(option, value));
    }
  }
  const std::size_t count = arguments.positional_.size();
  if (count < syntax.min_positional || count > syntax.max_positional) {
    const std::string surplus = count > syntax.max_positional ? arguments.positional_[syntax.max_positional] : "";
    return Refuse((surplus.empty() ? "" : "no place for '" + surplus + "'; ") + "usage: " + syntax.program +
                  (syntax.positional.empty() ? "" : " ") + std::string(syntax.positional));
  }
  return arguments;
}

std::string Arguments::text(std::string_view name, std::string_view otherwise) const {
  if (const auto found = given_.find(name); found != given_.end()) return found->second.back();
  const auto fallback = fallbacks_.find(name);
  return fallback == fallbacks_.end() ? std::string(otherwise) : fallback->second;
}

std::vector<std::string> Arguments::texts(std::string_view name) const {
  const auto found = given_.find(name);
  return found == given_.end() ? std::vector<std::string>{} : found->second;
}

core::Result<std::optional<double>> Arguments::number(std::string_view name) const {
  if (!has(name) && fallbacks_.find(name) == fallbacks_.end()) return std::optional<double>{};
  const std::optional<double> value = ReadNumber(text(name));
  if (!value) return Refuse(std::string(name) + " needs a number, not '" + text(name) + "'");
  return value;
}

core::Result<std::optional<double>> Arguments::positive(std::string_view name) const {
  auto value = number(name);
  if (value && *value && !(**value > 0.0)) {
    return Refuse(std::string(name) + " needs a number above zero, not '" + text(name) + "'");
  }
  return value;
}

core::Result<std::optional<std::uint64_t>> Arguments::count(std::string_view name, std::uint64_t least,
                                                            std::uint64_t most) const {
  if (!has(name) && fallbacks_.find(name) == fallbacks_.end()) return std::optional<std::uint64_t>{};
  const std::optional<std::uint64_t> value = ReadCount(text(name));
  if (!value || *value < least || *value > most) {
    return Refuse(Wanted({name, "", "", "", Count(least, most)}, text(name)));
  }
  return value;
}

double Arguments::checked_number(std::string_view name) const {
  return ReadNumber(text(name)).value_or(0.0);
}

std::uint64_t Arguments::checked_count(std::string_view name) const {
  return ReadCount(text(name)).value_or(0);
}

std::string Help(const Syntax& syntax) {
  std::string text = MakeApp(syntax)->help();
  if (!syntax.details.empty()) text += "\n" + std::string(syntax.details) + "\n";
  return text;
}

}  // namespace cli
