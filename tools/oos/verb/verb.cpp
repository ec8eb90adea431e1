#include "tools/oos/verb/verb.hpp"

#include <algorithm>
#include <cstdio>

namespace oos {
namespace {

void PrintHelp(const std::vector<Verb>& verbs) {
  std::printf("oos: runs and inspects simulations of telerobotic on-orbit servicing\n\nusage: oos VERB ...\n\n");
  for (const Verb& verb : verbs) {
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

int Complain(std::string_view verb, std::string_view what, int status) {
  std::fprintf(stderr, "oos %s: %s\n", std::string(verb).c_str(), std::string(what).c_str());
  return status;
}

int RunVerbs(const std::vector<Verb>& verbs, const std::vector<std::string>& words) {
  if (words.empty() || words[0] == "--help" || words[0] == "-h" || words[0] == "help") {
    PrintHelp(verbs);
    return words.empty() ? kBadUsage : kHolds;
  }
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
