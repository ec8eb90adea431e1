#pragma once

#include "bus/log/mcap_records.hpp"

namespace replay {

// Properties of the platform on which bits may depend: "simd" (widest instruction set that the program uses on this
// CPU), "libm" (version, and whether it uses fused multiply-add here), "cpu", "compiler", "denormals" (of the calling
// thread).
bus::log::TextMap DescribePlatform();

// Whether a recording made on `recorded` must give the same bits on `here`: same libm, compiler and treatment of
// denormals. The instruction set does not matter: the walks' results are the same with each (libs/vps).
bool GivesSameBits(const bus::log::TextMap& recorded, const bus::log::TextMap& here);

// For the calling thread: "flushed" or "kept".
void SetDenormals(const std::string& how);

}  // namespace replay
