#pragma once

#include <sys/types.h>

#include <string>

#include "core/result.hpp"

namespace oos {

// Describes a running session for the verbs that join it (places.hpp).
struct SessionNote {
  std::string registry;  // endpoint
  std::string session;   // number
  pid_t pid = 0;         // of `oos run`
  std::string out;       // its folder
  std::string keys;      // directory; empty: not encrypted
  std::string scenario;  // file
};

// One line of JSON.
std::string ToJson(const SessionNote& note);

// Errors: kNotFound, when registry or session is not there.
core::Result<SessionNote> ParseSessionNote(const std::string& json);

// Reads the note of the session on this machine. Errors: kNotFound; kInvalidInput if another user may have written it.
core::Result<SessionNote> FindSessionNote();

}  // namespace oos
