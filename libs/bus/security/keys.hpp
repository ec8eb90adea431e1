#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace bus {

// The members of a run. The launcher makes its key directory (mode 0700, files 0600):
//
//   allowed        one line for each member: "<public key> <name>"
//   <name>.key     two lines: public key, secret key
//
// A host needs `allowed` and the .key files of its own members only. Keys are CURVE25519 in Z85, 40 characters. The
// registry is the member "registry". A key named K is valid for nodes named K or K-anything: every tool of `oos` uses
// the key "oos".

constexpr const char* kRegistryKeyName = "registry";

struct KeyPair {
  std::string public_key;
  std::string secret_key;
};

struct Keys {
  KeyPair own;
  std::string own_name;                        // of the key
  std::map<std::string, std::string> allowed;  // public key -> name

  [[nodiscard]] std::string PublicKeyOf(const std::string& name) const;  // empty: no such member
};

// Creates the directory if missing, and a key pair for "registry" and each name that has none yet.
core::Result<void> MakeKeys(const std::filesystem::path& directory, const std::vector<std::string>& names);

// Loads the key of a node: the one of its name, or of the longest prefix of its name before a '-'. Refuses files that
// others can read, or that belong to another user.
core::Result<Keys> LoadKeys(const std::filesystem::path& directory, const std::string& node_name);

// Whether a key of that name is valid for that node.
bool IsKeyFor(const std::string& key_name, const std::string& node_name);

}  // namespace bus
