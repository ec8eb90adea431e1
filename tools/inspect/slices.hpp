#pragma once

#include <functional>
#include <string>

#include "core/result.hpp"
#include "picture/image.hpp"
#include "vps/asset/cooked_object.hpp"

namespace inspect {

// A field's value at a place in the mesh frame.
struct FieldPlace {
  double distance_m = 0.0;  // negative inside
  bool is_crease = false;   // the cell holds several tangent planes
  bool is_fine = true;      // the value is a voxel's, not the coarse grid's
  glm::ivec3 voxel{0};      // that holds the place
};

// Either method's field as a function of the place.
struct FieldView {
  std::string title;
  double voxel_size_m = 0.0;
  vps::Box box;  // of the grid
  std::function<FieldPlace(const glm::dvec3& p_m)> at;
};
// Both must outlive the view. Of a voxelmap the distance is minus the layer's value [VR-OOS, section 3], in steps of a
// voxel.
FieldView ViewOf(const vps::DistanceField& field);
FieldView ViewOf(const vps::Voxmap& map);

// Centre of the close-up, and the direction across the surface there (its normal).
struct CloseUp {
  glm::dvec3 centre_m{0.0};
  glm::dvec3 across{0.0, 0.0, 1.0};
};

// Three slices through the middle of the box along the axes, and a close-up in the axis plane that is nearest to
// perpendicular to the surface: distance in colour with iso-lines, the surface bold, crease cells and brick borders.
// Errors: those of Canvas::Create.
core::Result<picture::Image> DrawSlices(const FieldView& field, const vps::Box& box, const CloseUp& close_up);

}  // namespace inspect
