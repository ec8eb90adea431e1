#pragma once

#include "picture/image.hpp"
#include "picture/measured.hpp"

namespace raytrace {

// Light (three channels) as a picture for a screen: exposure, tone curve and sRGB.
picture::Image Develop(const picture::Measured<float>& light, float exposure);

}  // namespace raytrace
