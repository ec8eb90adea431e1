#include "nodes/visual_node/sky/ground.hpp"

#include <cstddef>
#include <span>
#include <utility>

// The files, with their ends, become part of the program.
// NOLINTBEGIN
asm(".pushsection .rodata\n"
    ".global vr_oos_ground, vr_oos_clouds, vr_oos_lights, vr_oos_lights_end\n"
    "vr_oos_ground:\n"
    ".incbin \"" VR_OOS_SKY_FOLDER
    "/ground.png\"\n"
    "vr_oos_clouds:\n"
    ".incbin \"" VR_OOS_SKY_FOLDER
    "/clouds.png\"\n"
    "vr_oos_lights:\n"
    ".incbin \"" VR_OOS_SKY_FOLDER
    "/lights.png\"\n"
    "vr_oos_lights_end:\n"
    ".byte 0\n"
    ".popsection\n");
extern "C" const std::byte vr_oos_ground[], vr_oos_clouds[], vr_oos_lights[], vr_oos_lights_end[];
// NOLINTEND

namespace visual_node {

core::Result<Ground> ReadGround() {
  auto colors = picture::ReadPng(std::span(vr_oos_ground, vr_oos_clouds));
  if (!colors) return tl::unexpected(colors.error());
  auto clouds = picture::ReadPng(std::span(vr_oos_clouds, vr_oos_lights));
  if (!clouds) return tl::unexpected(clouds.error());
  auto lights = picture::ReadPng(std::span(vr_oos_lights, vr_oos_lights_end));
  if (!lights) return tl::unexpected(lights.error());
  return Ground{std::move(*colors), std::move(*clouds), std::move(*lights)};
}

}  // namespace visual_node
