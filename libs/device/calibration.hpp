#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "core/pose.hpp"
#include "core/result.hpp"

namespace device {

// Where the base B of a specimen stands in W, found by touching known points.
struct Calibration {
  std::string name, serial;  // of the device
  core::Pose X_WB;
  double residual_m = 0.0;          // root mean square distance of the points after the fit
  double largest_residual_m = 0.0;  // of one point
  int num_points = 0;
};

// The rigid motion that takes the points p_Bs as near as possible to p_Ws in the mean square [Horn 1987]. Errors:
// kInvalidInput for fewer than three points, for points on one line, and for numbers that are not finite.
core::Result<Calibration> FitRigid(std::span<const glm::dvec3> p_Bs, std::span<const glm::dvec3> p_Ws);

// Calibrations are kept in one file for each specimen, in $VR_OOS_DEVICES, else $XDG_CONFIG_HOME/vr_oos/devices, else
// ~/.config/vr_oos/devices.
std::filesystem::path CalibrationFolder();
std::filesystem::path CalibrationFile(const std::filesystem::path& folder, const std::string& name,
                                      const std::string& serial);
core::Result<void> Keep(const Calibration& calibration, const std::filesystem::path& folder);
// None: there is no file of that specimen, or it cannot be read (then *why says so).
std::optional<Calibration> FindCalibration(const std::filesystem::path& folder, const std::string& name,
                                           const std::string& serial, std::string* why);

}  // namespace device
