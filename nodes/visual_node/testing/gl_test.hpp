#pragma once

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <link.h>

#include <cstdlib>
#include <string>

#include "nodes/visual_node/gl/gl_context.hpp"

namespace visual_node {

// The leak checker finds a leak's library only while it is loaded. Mesa unloads its driver with the display, so the
// suppressions for the driver in tests/sanitizers/lsan.supp would have no effect.
inline void KeepDriverLoaded() {
#if defined(__SANITIZE_ADDRESS__)
  std::string driver;
  dl_iterate_phdr(
      [](dl_phdr_info* library, std::size_t, void* found) {
        const std::string name = library->dlpi_name;
        if (name.ends_with("_dri.so")) *static_cast<std::string*>(found) = name;
        return 0;
      },
      &driver);
  if (!driver.empty()) dlopen(driver.c_str(), RTLD_NOW | RTLD_NODELETE | RTLD_NOLOAD);
#endif
}

// A test that draws. One display for all tests of the process; without one they are skipped with the reason.
class GlTest : public testing::Test {
 protected:
  void SetUp() override {
    if (context() == nullptr) GTEST_SKIP() << why_;
  }

 private:
  static GlContext* context() {
    if (context_ != nullptr || !why_.empty()) return context_;
    setenv("LP_NUM_THREADS", "1", 0);
    auto context = GlContext::Create({.width = 64, .height = 64, .title = "test", .is_visible = false});
    if (context) {
      context_ = context->release();  // to the end of the process
      KeepDriverLoaded();
    } else {
      why_ = context.error().detail;
    }
    return context_;
  }

  static inline GlContext* context_ = nullptr;
  static inline std::string why_;
};

}  // namespace visual_node
