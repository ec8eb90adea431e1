#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/arguments.hpp"

namespace oos {

using cli::Arguments;
using cli::Option;

// Exit status of every verb.
constexpr int kHolds = 0;        // success: the run or check passed
constexpr int kDoesNotHold = 1;  // it does not
constexpr int kBadUsage = 2;     // bad usage or input

struct Verb {
  std::string_view name;
  std::string_view summary;     // one line for `oos --help`
  std::string_view positional;  // as shown in the usage line
  std::size_t min_positional = 0;
  std::size_t max_positional = 0;
  std::vector<Option> options;
  int (*run)(const Arguments&) = nullptr;
  std::string_view details = "";  // printed below the options by --help
};

// Runs the verb that `words` name (the command line without the program's name), if it is one of `verbs`. Returns the
// exit status.
int RunVerbs(const std::vector<Verb>& verbs, const std::vector<std::string>& words);

// Prints "oos VERB: what" to stderr and returns `status`.
int Complain(std::string_view verb, std::string_view what, int status);

}  // namespace oos
