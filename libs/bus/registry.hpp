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
  std::string keys = {};     // key directory of the run, see bus/keys.hpp
  bool is_encrypted = true;  // false, said explicitly: no keys
};

// Where nodes find each other: it takes their HELLO and pushes the roster to all. No data passes through it, and data
// goes on flowing when it dies; a new one is filled again by the periodic HELLO of every node (2 per second).
// It refuses, with names: a second live node of the same name, a LATEST or STATE topic with two live writers, a schema
// that contradicts the one another node has for the same topic, another session, another protocol version.
//
// Names and written topics have one holder. Each holder has an epoch (NodeRecord.boot), which grows from one to the
// next. Whoever takes the place of one that died (silent for 0.8 s), or takes it over explicitly, fences it off: a
// fenced instance is told so at its next HELLO, for good, its peers drop its connections, and what still comes from it
// is refused and counted. Of two that were let in by different lives of the registry, the later epoch stays.
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
