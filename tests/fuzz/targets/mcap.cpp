#include "bus/log/mcap_reader.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/scratch_folder.hpp"
#include "tests/fuzz/targets.hpp"

namespace fuzz {

// The input as a file. Recovery keeps all that the reader accepts, and the reader accepts all that recovery writes.
void FuzzMcap(Input input) {
  static const ScratchFolder folder;
  const std::filesystem::path file = folder.Write("in.mcap", input);
  std::uint64_t num_read = 0;
  const auto count = [&num_read](const bus::log::Channel&, const bus::log::Message&) { ++num_read; };
  const auto contents = bus::log::ReadMcap(file, count);
  if (contents) Claim(contents->statistics.message_count == num_read, "every message that is counted is shown");

  const std::filesystem::path saved = folder.path() / "out.mcap";
  std::filesystem::remove(saved);
  const auto recovery = bus::log::RecoverMcap(file, saved);
  if (contents && contents->has_summary && num_read > 0) {
    Claim(recovery && recovery->num_messages == num_read && recovery->was_whole, "a whole file is saved whole");
  }
  if (!recovery) return;
  num_read = 0;
  Claim(bus::log::ReadMcap(saved, count).has_value(), "what was saved can be read");
  Claim(num_read == recovery->num_messages, "as many messages as recovery says");
}

}  // namespace fuzz
