#include "lab/load_lab.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/scratch_folder.hpp"
#include "tests/fuzz/targets.hpp"

namespace fuzz {

void FuzzLab(Input input) {
  static const ScratchFolder folder;
  const auto lab = lab::LoadLab(folder.Write("lab.xml", input));
  if (lab) {
    (void)lab::CheckAgainst(*lab, {}, {"visual_node"});
  } else {
    Claim(!lab.error().empty(), "a refusal says why");
  }
}

}  // namespace fuzz
