#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace core {

// What went wrong, for programs (`code`) and for people (`detail`: what, where, why and how to fix it).
enum class ErrorCode { kNotFound, kInvalidInput, kDamaged, kIo, kUnsupported, kTimeout, kResource };

struct Error {
  ErrorCode code = ErrorCode::kInvalidInput;
  std::string detail;
};

// The return type of everything that can fail at setup. A real-time step returns status bits instead.
template <typename T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> Fail(ErrorCode code, std::string detail) {
  return tl::unexpected<Error>(Error{code, std::move(detail)});
}

}  // namespace core
