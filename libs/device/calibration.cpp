#include "device/calibration.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/read_file.hpp"
#include "core/write_file.hpp"

namespace device {
namespace {

using Matrix4 = std::array<std::array<double, 4>, 4>;

// The eigenvector of a symmetric matrix's largest eigenvalue, by cyclic Jacobi rotations. `others`: the second largest
// eigenvalue, and the largest one.
std::array<double, 4> LargestEigenvector(Matrix4 a, std::array<double, 2>* others) {
  Matrix4 v{};
  for (std::size_t i = 0; i < 4; ++i) v[i][i] = 1.0;
  constexpr int kSweeps = 30;  // converges quadratically: five are enough for double precision
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t p = 0; p < 3; ++p) {
      for (std::size_t q = p + 1; q < 4; ++q) {
        if (std::abs(a[p][q]) < 1e-300) continue;
        const double theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
        for (std::size_t k = 0; k < 4; ++k) {
          const double kp = a[k][p], kq = a[k][q];
          a[k][p] = c * kp - s * kq;
          a[k][q] = s * kp + c * kq;
        }
        for (std::size_t k = 0; k < 4; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = c * pk - s * qk;
          a[q][k] = s * pk + c * qk;
          const double vp = v[k][p], vq = v[k][q];
          v[k][p] = c * vp - s * vq;
          v[k][q] = s * vp + c * vq;
        }
      }
    }
  }
  std::array<std::size_t, 4> order = {0, 1, 2, 3};
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return a[i][i] > a[j][j]; });
  *others = {a[order[1]][order[1]], a[order[0]][order[0]]};
  const std::size_t best = order[0];
  return {v[0][best], v[1][best], v[2][best], v[3][best]};
}

glm::dvec3 Mean(std::span<const glm::dvec3> points) {
  glm::dvec3 sum(0.0);
  for (const glm::dvec3& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

// A device says its own name, so only characters that are safe in a file's name are kept.
std::string Safe(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' ? c : '_';
  return safe;
}

}  // namespace

// With the points' distances from their means, b and w, and S = sum b w^T, the quaternion of R_WB is the eigenvector of
// the largest eigenvalue of
//       [ Sxx+Syy+Szz  Syz-Szy      Szx-Sxz      Sxy-Syx     ]
//   N = [ .            Sxx-Syy-Szz  Sxy+Syx      Szx+Sxz     ]
//       [ .            .            Syy-Sxx-Szz  Syz+Szy     ]
//       [ .            .            .            Szz-Sxx-Syy ]
// which is a simple one unless the points lie on one line.
core::Result<Calibration> FitRigid(std::span<const glm::dvec3> p_Bs, std::span<const glm::dvec3> p_Ws) {
  if (p_Bs.size() != p_Ws.size() || p_Bs.size() < 3) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "calibration needs three points or more, not " + std::to_string(p_Ws.size()));
  }
  const glm::dvec3 mean_B = Mean(p_Bs), mean_W = Mean(p_Ws);
  glm::dmat3 S(0.0);  // S[column][row]; S[j][i] = sum b_i w_j
  double spread = 0.0;
  for (std::size_t k = 0; k < p_Bs.size(); ++k) {
    const glm::dvec3 b = p_Bs[k] - mean_B, w = p_Ws[k] - mean_W;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) S[j][i] += b[i] * w[j];
    }
    spread += glm::dot(b, b) + glm::dot(w, w);
  }
  if (!std::isfinite(spread)) return core::Fail(core::ErrorCode::kInvalidInput, "a point is not finite");
  const auto s = [&S](int i, int j) { return S[j][i]; };
  Matrix4 n{};
  n[0] = {s(0, 0) + s(1, 1) + s(2, 2), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0)};
  n[1] = {n[0][1], s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2)};
  n[2] = {n[0][2], n[1][2], s(1, 1) - s(0, 0) - s(2, 2), s(1, 2) + s(2, 1)};
  n[3] = {n[0][3], n[1][3], n[2][3], s(2, 2) - s(0, 0) - s(1, 1)};
  std::array<double, 2> eigenvalues{};
  const std::array<double, 4> q = LargestEigenvector(n, &eigenvalues);
  // The gap of the two largest is as large as the square of the points' spread across their longest line.
  if (eigenvalues[1] - eigenvalues[0] < 1e-6 * spread || spread <= 0.0) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "the points lie on one line, or the device was not moved to each; choose a triangle");
  }
  Calibration calibration;
  calibration.X_WB.rotation = glm::normalize(glm::dquat(q[0], q[1], q[2], q[3]));
  calibration.X_WB.translation = mean_W - calibration.X_WB.rotate(mean_B);
  calibration.num_points = static_cast<int>(p_Bs.size());
  double sum = 0.0;
  for (std::size_t k = 0; k < p_Bs.size(); ++k) {
    const double distance_m = glm::length(calibration.X_WB * p_Bs[k] - p_Ws[k]);
    sum += distance_m * distance_m;
    calibration.largest_residual_m = std::max(calibration.largest_residual_m, distance_m);
  }
  calibration.residual_m = std::sqrt(sum / static_cast<double>(p_Bs.size()));
  return calibration;
}

std::filesystem::path CalibrationFolder() {
  if (const char* folder = std::getenv("VR_OOS_DEVICES"); folder != nullptr && *folder != '\0') return folder;
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config != nullptr && *config != '\0') {
    return std::filesystem::path(config) / "vr_oos" / "devices";
  }
  const char* home = std::getenv("HOME");
  return std::filesystem::path(home != nullptr ? home : ".") / ".config" / "vr_oos" / "devices";
}

std::filesystem::path CalibrationFile(const std::filesystem::path& folder, const std::string& name,
                                      const std::string& serial) {
  return folder / (Safe(name) + "-" + Safe(serial) + ".json");
}

core::Result<void> Keep(const Calibration& calibration, const std::filesystem::path& folder) {
  const core::Pose& X = calibration.X_WB;
  const nlohmann::json json = {
      {"name", calibration.name},
      {"serial", calibration.serial},
      {"X_WB",
       {X.rotation.w, X.rotation.x, X.rotation.y, X.rotation.z, X.translation.x, X.translation.y, X.translation.z}},
      {"residual_m", calibration.residual_m},
      {"largest_residual_m", calibration.largest_residual_m},
      {"num_points", calibration.num_points}};
  return core::WriteFile(CalibrationFile(folder, calibration.name, calibration.serial), json.dump(2) + "\n");
}

std::optional<Calibration> FindCalibration(const std::filesystem::path& folder, const std::string& name,
                                           const std::string& serial, std::string* why) {
  const std::filesystem::path file = CalibrationFile(folder, name, serial);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return std::nullopt;
  const auto text = core::ReadFile(file);
  if (!text) {
    *why = file.string() + ": " + text.error().detail;
    return std::nullopt;
  }
  const nlohmann::json json = nlohmann::json::parse(text->begin(), text->end(), nullptr, false);
  const auto number = [](const nlohmann::json& value, double* to) {
    if (value.is_number()) *to = value.get<double>();
    return value.is_number() && std::isfinite(*to);
  };
  Calibration calibration;
  calibration.name = name;
  calibration.serial = serial;
  bool is_valid = json.is_object() && json.contains("X_WB") && json["X_WB"].is_array() && json["X_WB"].size() == 7 &&
                  json.contains("residual_m") && number(json["residual_m"], &calibration.residual_m);
  std::array<double, 7> x{};
  for (std::size_t i = 0; is_valid && i < x.size(); ++i) is_valid = number(json["X_WB"][i], &x[i]);
  const glm::dquat q(x[0], x[1], x[2], x[3]);
  if (!is_valid || std::abs(glm::dot(q, q) - 1.0) > 1e-3) {
    *why = file.string() + ": is no calibration; remove it and calibrate again";
    return std::nullopt;
  }
  calibration.X_WB = {glm::normalize(q), {x[4], x[5], x[6]}};
  return calibration;
}

}  // namespace device
