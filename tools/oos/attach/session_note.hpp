#pragma once

#include <sys/types.h>

#include <string>

#include "core/result.hpp"

namespace oos {

// What a running session leaves for the verbs that look into it (places.hpp).
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

// Of the session that runs here. Errors: kNotFound; kInvalidInput, when somebody else may have written the note.
core::Result<SessionNote> FindSessionNote();

}  // namespace oos
