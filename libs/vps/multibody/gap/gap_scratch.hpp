#pragma once

#include "vps/multibody/gap/choose_places.hpp"

namespace vps {

// Memory of a query. Large, and little of it is used by one, so it is not made anew for each.
struct GapScratch {
  TouchBins bins;
  CornersBelow below;
  MeasuredCorners corners;
  GapCandidates candidates;
  FacetsAround around;
};

}  // namespace vps
