#pragma once

#include <string_view>
#include <vector>

#include "tools/oos/arguments.hpp"

namespace oos {

// Exit status of every verb.
constexpr int kHolds = 0;        // what was asked for holds
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

// One file per verb.
Verb RunVerb();
Verb CheckVerb();
Verb CookVerb();
Verb DoctorVerb();
Verb TopicVerb();
Verb TopVerb();
Verb FetchVerb();
Verb ViewVerb();
Verb SweepVerb();
Verb SetVerb();
Verb LatencyVerb();
Verb QueryVerb();
Verb InspectVerb();
Verb BenchVerb();
Verb RecordVerb();
Verb InfoVerb();
Verb CatVerb();
Verb RecoverVerb();
Verb MergeVerb();
Verb DiffVerb();
Verb ExportVerb();
Verb LaunchVerb();
Verb StatusVerb();
Verb AttachVerb();
Verb StopVerb();
Verb RegistryVerb();
Verb ClockVerb();
Verb ReplayVerb();

std::vector<Verb> AllVerbs();

// Runs the verb that `words` (the command line without the program's name) ask for; returns the exit status.
int RunCommandLine(const std::vector<std::string>& words);

// Prints "oos VERB: what" to stderr and returns `status`.
int Complain(std::string_view verb, std::string_view what, int status);

}  // namespace oos
