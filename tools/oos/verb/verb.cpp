#include "tools/oos/verb/verb.hpp"

#include <algorithm>
#include <cstdio>

#include "core/names.hpp"

namespace oos {
namespace {

void PrintHelp(const std::vector<Verb>& verbs) {
  std::printf("oos: runs and inspects simulations of telerobotic on-orbit servicing\n\nusage: oos VERB ...\n\n");
  for (const Verb& verb : verbs) {
    std::printf("  %-8s %s\n", std::string(verb.name).c_str(), std::string(verb.summary).c_str());
  }
  std::printf(
      "\n'oos VERB --help' shows its options, 'oos --version' the version. Exit status: 0 success, 1 the run or check "
      "failed, 2 bad usage or "
      "input.\n");
}

int RefuseVerb(const std::vector<Verb>& verbs, const std::string& word) {
  std::vector<std::string> names;
  for (const Verb& verb : verbs) names.emplace_back(verb.name);
  const std::string nearest = core::NearestName(word, names);
  const std::string remedy = nearest.empty() ? "" : "did you mean '" + nearest + "'? ";
  const char* kind = word.rfind('-', 0) == 0 ? "unknown option" : "no verb";
  std::fprintf(stderr, "oos: %s '%s'; %s'oos --help' lists the verbs\n", kind, word.c_str(), remedy.c_str());
  return kBadUsage;
}

cli::Syntax SyntaxOf(const Verb& verb) {
  return {"oos " + std::string(verb.name),
          verb.summary,
          verb.positional,
          verb.min_positional,
          verb.max_positional,
          verb.options,
          verb.details};
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
  if (verb == verbs.end()) return RefuseVerb(verbs, words[0]);
  const cli::Syntax syntax = SyntaxOf(*verb);
  const auto arguments = Arguments::Parse({words.begin() + 1, words.end()}, syntax);
  if (!arguments) return Complain(verb->name, arguments.error().detail, kBadUsage);
  if (arguments->wants_help()) {
    std::printf("%s", cli::Help(syntax).c_str());
    return kHolds;
  }
  return verb->run(*arguments);
}

}  // namespace oos
