#include <cinttypes>
#include <cstdio>

#include "bus/log/compare_mcap.hpp"
#include "bus/log/merge_mcap.hpp"
#include "tools/oos/record/recording_memory.hpp"
#include "tools/oos/record/verbs.hpp"

namespace oos {
namespace {

int Merge(const Arguments& arguments) {
  const std::vector<std::filesystem::path> files(arguments.positional().begin(), arguments.positional().end());
  if (!arguments.has("--out")) return Complain("merge", "--out FILE is missing", kBadUsage);
  const std::string out = arguments.text("--out");
  const auto merge = bus::log::MergeMcap(files, out);
  if (!merge) return Complain("merge", merge.error().detail, kBadUsage);
  for (const std::string& file : merge->incomplete) std::printf("its writer died: %s\n", file.c_str());
  std::printf("%s: %" PRIu64 " messages of %zu files", out.c_str(), merge->num_messages, files.size());
  if (merge->num_machines > 1) {
    std::printf(", clocks of %zu machines compared within %.1f us", merge->num_machines,
                static_cast<double>(merge->bound_ns) * 1e-3);
  }
  std::printf("\n");
  return kHolds;
}

int Diff(const Arguments& arguments) {
  const std::string pattern = arguments.positional().size() == 3 ? arguments.positional()[2] : "*";
  const auto comparison = bus::log::CompareMcap(arguments.positional()[0], arguments.positional()[1], pattern);
  if (!comparison) return Complain("diff", comparison.error().detail, kBadUsage);
  std::printf("%-44s %-16s %9s %9s %9s %9s %9s\n", "topic", "writer", "first", "second", "only 1st", "only 2nd",
              "differ");
  for (const auto& c : comparison->channels) {
    std::printf("%-44s %-16s %9" PRIu64 " %9" PRIu64 " %9" PRIu64 " %9" PRIu64 " %9" PRIu64 "\n",
                (c.key.empty() ? c.topic : c.topic + " [" + c.key + "]").c_str(), c.node.c_str(), c.num_a, c.num_b,
                c.num_only_a, c.num_only_b, c.num_different);
  }
  if (comparison->is_same()) {
    std::printf("the same messages\n");
    return kHolds;
  }
  const auto& first = *comparison->first;
  std::printf("first difference: %s of %s, sequence %" PRIu32 ", at %.6f s\n%s\n", first.topic.c_str(),
              first.node.c_str(), first.sequence, static_cast<double>(first.log_time_ns) * 1e-9, first.what.c_str());
  return kDoesNotHold;
}

}  // namespace

Verb MergeVerb() {
  return {"merge",
          "joins recordings of one run, with times by one clock",
          "FILE... --out FILE",
          1,
          1000,
          {{"--out", "FILE", "must not exist"}},
          [](const Arguments& arguments) { return WithinMemory("merge", arguments, Merge); },
          "Times are converted to the clock of the first file's machine, by the clock samples that nodes record."};
}

Verb DiffVerb() {
  return {"diff",
          "compares two recordings: counts by topic, first message and field that differ",
          "A B [PATTERN]",
          2,
          3,
          {},
          [](const Arguments& arguments) { return WithinMemory("diff", arguments, Diff); },
          "Compares payloads by topic, writer and sequence number, and ignores times."};
}

}  // namespace oos
