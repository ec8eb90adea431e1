#pragma once

#include <string>

namespace oos {

enum class Grade { kOk, kWarn, kFail };

// One line of `oos doctor`.
struct Finding {
  const char* subject = "";  // for programs
  Grade grade = Grade::kOk;
  std::string what;
  std::string remedy;  // empty when OK
};

}  // namespace oos
