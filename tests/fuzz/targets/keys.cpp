#include "bus/security/keys.hpp"

#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/reader.hpp"
#include "tests/fuzz/scratch_folder.hpp"

namespace fuzz {

// The files of a key directory: the list of allowed keys, and a node's own key pair.
void FuzzKeys(Input input) {
  static const ScratchFolder folder;
  Reader reader(input);
  folder.Write("allowed", reader.Piece());
  folder.Write("physics_node.key", reader.Piece());
  const auto keys = bus::LoadKeys(folder.path(), "physics_node");
  if (!keys) return;
  Claim(keys->own_name == "physics_node" && keys->own.secret_key.size() == 40, "a key that is taken is a key");
  Claim(!keys->PublicKeyOf(bus::kRegistryKeyName).empty(), "the registry is known");
}

}  // namespace fuzz
