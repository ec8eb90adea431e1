#include "tools/oos/verb.hpp"

#include <algorithm>
#include <cstdio>

namespace oos {
namespace {

void PrintHelp() {
  std::printf("oos: runs and inspects simulations of telerobotic on-orbit servicing\n\nusage: oos VERB ...\n\n");
  for (const Verb& verb : AllVerbs()) {
    std::printf("  %-8s %s\n", std::string(verb.name).c_str(), std::string(verb.summary).c_str());
  }
  std::printf(
      "\n'oos VERB --help' says more. Exit status: 0 what was asked for holds, 1 it does not, 2 bad usage or input.\n");
}

void PrintVerbHelp(const Verb& verb) {
  std::printf("usage: oos %s %s%s\n%s\n", std::string(verb.name).c_str(), std::string(verb.positional).c_str(),
              verb.options.empty() ? "" : " [options]", std::string(verb.summary).c_str());
  for (const Option& option : verb.options) {
    const std::string left =
        std::string(option.name) + (option.value_name.empty() ? "" : " " + std::string(option.value_name));
    std::printf("  %-24s %s\n", left.c_str(), std::string(option.help).c_str());
  }
  if (!verb.details.empty()) std::printf("\n%s\n", std::string(verb.details).c_str());
}

}  // namespace

std::vector<Verb> AllVerbs() {
  return {RunVerb(),    CheckVerb(),  CookVerb(),    DoctorVerb(),   TopicVerb(), TopVerb(),    ViewVerb(),
          SweepVerb(),  SetVerb(),    LatencyVerb(), InspectVerb(),  QueryVerb(), BenchVerb(),  RecordVerb(),
          InfoVerb(),   CatVerb(),    RecoverVerb(), MergeVerb(),    DiffVerb(),  ExportVerb(), LaunchVerb(),
          StatusVerb(), AttachVerb(), StopVerb(),    RegistryVerb(), ClockVerb(), ReplayVerb(), FetchVerb()};
}

int Complain(std::string_view verb, std::string_view what, int status) {
  std::fprintf(stderr, "oos %s: %s\n", std::string(verb).c_str(), std::string(what).c_str());
  return status;
}

int RunCommandLine(const std::vector<std::string>& words) {
  if (words.empty() || words[0] == "--help" || words[0] == "-h" || words[0] == "help") {
    PrintHelp();
    return words.empty() ? kBadUsage : kHolds;
  }
  const std::vector<Verb> verbs = AllVerbs();
  const auto verb = std::find_if(verbs.begin(), verbs.end(), [&](const Verb& v) { return v.name == words[0]; });
  if (verb == verbs.end()) {
    std::fprintf(stderr, "oos: no verb '%s'; 'oos --help' lists them\n", words[0].c_str());
    return kBadUsage;
  }
  const std::vector<std::string> rest(words.begin() + 1, words.end());
  if (std::find(rest.begin(), rest.end(), "--help") != rest.end()) {
    PrintVerbHelp(*verb);
    return kHolds;
  }
  const core::Result<Arguments> arguments = Arguments::Parse(rest, verb->options);
  if (!arguments) return Complain(verb->name, arguments.error().detail, kBadUsage);
  const std::size_t count = arguments->positional().size();
  if (count < verb->min_positional || count > verb->max_positional) {
    return Complain(verb->name, "usage: oos " + std::string(verb->name) + " " + std::string(verb->positional),
                    kBadUsage);
  }
  return verb->run(*arguments);
}

}  // namespace oos
