#include <array>
#include <cstring>
#include <vector>

#include "core/hash.hpp"
#include "physics/checkpoint_file.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/scratch_folder.hpp"
#include "tests/fuzz/targets.hpp"

namespace fuzz {
namespace {

constexpr std::size_t kHeadBytes = 40;
constexpr std::size_t kContentAt = 16;
constexpr std::size_t kChecksumAt = 32;

void Check(const ScratchFolder& folder, Input bytes) {
  const std::filesystem::path file = folder.Write("checkpoint", bytes);
  std::uint64_t content = 0;
  if (bytes.size() >= kHeadBytes) std::memcpy(&content, &bytes[kContentAt], sizeof(content));
  std::array<physics::Checkpoint, 2> parts;
  std::array<physics::Checkpoint*, 2> places{&parts[0], &parts[1]};
  const auto tick = physics::ReadCheckpointFile(file, content, places);
  if (!tick) return;
  Claim(kHeadBytes + 16 + parts[0].bytes().size() + parts[1].bytes().size() == bytes.size(), "every byte is in a part");
  Claim(!physics::ReadCheckpointFile(file, content + 1, places), "another scenario's checkpoint is refused");
}

}  // namespace

// The input unchanged, and with its checksum corrected.
void FuzzCheckpoint(Input input) {
  static const ScratchFolder folder;
  Check(folder, input);
  if (input.size() < kHeadBytes) return;
  std::vector<std::uint8_t> corrected(input.begin(), input.end());
  const std::uint64_t checksum = core::Hash64(corrected.data() + kHeadBytes, corrected.size() - kHeadBytes,
                                              core::Hash64(corrected.data(), kChecksumAt));
  std::memcpy(&corrected[kChecksumAt], &checksum, sizeof(checksum));
  Check(folder, corrected);
}

}  // namespace fuzz
