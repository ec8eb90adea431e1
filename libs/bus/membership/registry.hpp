#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace bus {

struct RegistryOptions {
  std::string endpoint = "tcp://127.0.0.1:0";  // port 0: any free one, see endpoint()
  std::uint64_t session = 0;
  std::string keys = {};     // key directory of the run, see bus/security/keys.hpp
  bool is_encrypted = true;  // false must be set explicitly: no keys
};

// Introduces the nodes to each other: it takes their HELLO and pushes the roster to all. No data passes through it, so
// data flows on when it dies; a new registry learns all nodes from their periodic HELLO (2 per second). It refuses,
// with names: a second live node of the same name, a LATEST or STATE topic with two live writers, a schema incompatible
// with another node's for the same topic, another session, another protocol version.
//
// Each name and written topic has one holder, and each holder an epoch (NodeRecord.boot), which grows from one holder
// to the next. A node that replaces a dead one (silent for 0.8 s), or takes over explicitly, fences it off for good:
// the registry refuses its next HELLO, its peers close its connections, and what it still sends is refused and counted.
// Of two holders admitted by different lives of the registry, the later epoch stays.
class Registry {
 public:
  static core::Result<std::unique_ptr<Registry>> Create(const RegistryOptions& options);
  ~Registry();
  Registry(const Registry&) = delete;
  Registry& operator=(const Registry&) = delete;

  [[nodiscard]] const std::string& endpoint() const;        // to give to nodes
  [[nodiscard]] std::vector<std::string> Names() const;     // registered now; any thread
  [[nodiscard]] std::vector<std::string> Refusals() const;  // texts, oldest first; any thread
  [[nodiscard]] std::uint64_t num_refused() const;          // connections and messages; any thread

 private:
  struct Impl;
  explicit Registry(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace bus
