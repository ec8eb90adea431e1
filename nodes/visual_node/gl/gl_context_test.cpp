#include "nodes/visual_node/gl/gl_context.hpp"

#include <gtest/gtest.h>

namespace visual_node {
namespace {

TEST(GlContext, KnowsWhetherThereIsAGraphicsCard) {
  for (const char* name :
       {"llvmpipe (LLVM 15.0.6, 256 bits)", "softpipe", "Software Rasterizer swrast", "SWR (LLVM 11)"}) {
    EXPECT_TRUE(IsSoftwareRenderer(name)) << name;
  }
  for (const char* name : {"NVIDIA RTX A4000/PCIe/SSE2", "AMD Radeon RX 6600 (navi23, LLVM 15.0.6, DRM 3.49)",
                           "Mesa Intel(R) UHD Graphics 620 (KBL GT2)", "V3D 4.2"}) {
    EXPECT_FALSE(IsSoftwareRenderer(name)) << name;
  }
}

}  // namespace
}  // namespace visual_node
