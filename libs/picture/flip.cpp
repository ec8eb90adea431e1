#include "picture/flip.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

namespace picture {
namespace {

// Symbols and constants are those of the paper.
constexpr double kPi = 3.14159265358979323846;
constexpr double kQc = 0.7, kPc = 0.4, kPt = 0.95;  // of the colours' difference
constexpr double kQf = 0.5, kFeature_deg = 0.082;   // of the features' difference, and the width of an edge
constexpr std::array<double, 3> kWhite = {0.950428545, 1.0, 1.088900371};  // XYZ of D65

// One channel, rows from the top.
struct Plane {
  int width = 0, height = 0;
  std::vector<double> values;
  Plane(int w, int h) : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  [[nodiscard]] std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};
using Planes = std::array<Plane, 3>;
using Kernel = std::vector<double>;  // of odd length, its middle is offset 0

double DecodeSrgb(std::uint8_t code) {
  const double s = code / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

glm::dvec3 LinearToXyz(const glm::dvec3& c) {
  return {0.4123907993 * c.r + 0.3575843394 * c.g + 0.1804807884 * c.b,
          0.2126390059 * c.r + 0.7151686788 * c.g + 0.0721923154 * c.b,
          0.0193308187 * c.r + 0.1191947798 * c.g + 0.9505321522 * c.b};
}

glm::dvec3 XyzToLinear(const glm::dvec3& p) {
  static const glm::dmat3 inverse =
      glm::inverse(glm::dmat3(LinearToXyz({1, 0, 0}), LinearToXyz({0, 1, 0}), LinearToXyz({0, 0, 1})));
  return inverse * p;
}

// The opponent space whose channels the eye filters: lightness, red-green, blue-yellow; linear in XYZ.
glm::dvec3 LinearToYCxCz(const glm::dvec3& c) {
  const glm::dvec3 p = LinearToXyz(c);
  const double x = p.x / kWhite[0], y = p.y / kWhite[1], z = p.z / kWhite[2];
  return {116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

glm::dvec3 YCxCzToLinear(const glm::dvec3& v) {
  const double y = (v.x + 16.0) / 116.0;
  return XyzToLinear({(v.y / 500.0 + y) * kWhite[0], y * kWhite[1], (y - v.z / 200.0) * kWhite[2]});
}

// CIELAB, its chroma scaled by the lightness (Hunt: colours look more colourful in more light).
glm::dvec3 LinearToHuntLab(const glm::dvec3& c) {
  constexpr double kDelta = 6.0 / 29.0;
  const auto f = [](double t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3.0 * kDelta * kDelta) + 4.0 / 29.0;
  };
  const glm::dvec3 p = LinearToXyz(c);
  const double x = f(p.x / kWhite[0]), y = f(p.y / kWhite[1]), z = f(p.z / kWhite[2]);
  const double lightness = 116.0 * y - 16.0;
  return {lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)};
}

double HyAb(const glm::dvec3& a, const glm::dvec3& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

// 0 to 1: small differences take most of the range.
double ColorError(const glm::dvec3& a, const glm::dvec3& b) {
  static const double most = std::pow(HyAb(LinearToHuntLab({0.0, 1.0, 0.0}), LinearToHuntLab({0.0, 0.0, 1.0})), kQc);
  const double error = std::pow(HyAb(LinearToHuntLab(a), LinearToHuntLab(b)), kQc);
  const double knee = kPc * most;
  return error < knee ? kPt / knee * error : kPt + (error - knee) / (most - knee) * (1.0 - kPt);
}

Planes ToYCxCz(const Image& image) {
  const Plane plane(image.width, image.height);
  Planes planes = {plane, plane, plane};
  for (std::size_t i = 0; i < plane.values.size(); ++i) {
    const std::uint8_t* p = &image.rgba[4 * i];
    const glm::dvec3 v = LinearToYCxCz({DecodeSrgb(p[0]), DecodeSrgb(p[1]), DecodeSrgb(p[2])});
    for (int k = 0; k < 3; ++k) planes[static_cast<std::size_t>(k)].values[i] = v[k];
  }
  return planes;
}

// Correlates with a(x) b(y). Pixels beyond the border are those on it.
Plane Filter(const Plane& from, const Kernel& along_x, const Kernel& along_y) {
  const auto pass = [](const Plane& in, const Kernel& kernel, int dx, int dy) {
    const int radius = static_cast<int>(kernel.size()) / 2;
    Plane out(in.width, in.height);
    for (int y = 0; y < in.height; ++y) {
      for (int x = 0; x < in.width; ++x) {
        double sum = 0.0;
        for (int k = -radius; k <= radius; ++k) {
          const int at_x = std::clamp(x + k * dx, 0, in.width - 1), at_y = std::clamp(y + k * dy, 0, in.height - 1);
          sum += kernel[static_cast<std::size_t>(k + radius)] * in.values[in.Index(at_x, at_y)];
        }
        out.values[out.Index(x, y)] = sum;
      }
    }
    return out;
  };
  return pass(pass(from, along_x, 1, 0), along_y, 0, 1);
}

template <class Function>
Kernel Sample(int radius, Function&& value) {
  Kernel kernel;
  for (int k = -radius; k <= radius; ++k) kernel.push_back(value(static_cast<double>(k)));
  return kernel;
}

double Sum(const Kernel& kernel) {
  double sum = 0.0;
  for (const double value : kernel) sum += value;
  return sum;
}

// What the eye resolves of a channel: contrast sensitivity as a sum of Gaussians a sqrt(pi / b) exp(-pi^2 d^2 / b), d
// in degrees, of total weight 1.
Plane FilterAsTheEye(const Plane& channel, const std::vector<glm::dvec2>& a_b, double pixels_per_degree) {
  constexpr double kWidestB = 0.04;  // of all channels, so that all have the same radius
  const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(kWidestB / (2.0 * kPi * kPi)) * pixels_per_degree));
  Plane sum(channel.width, channel.height);
  double total = 0.0;
  for (const glm::dvec2& term : a_b) {
    const double a = term.x, b = term.y;
    const Kernel gauss = Sample(radius, [&](double k) {
      const double degrees = k / pixels_per_degree;
      return std::exp(-kPi * kPi * degrees * degrees / b);
    });
    const double weight = a * std::sqrt(kPi / b);
    const Plane part = Filter(channel, gauss, gauss);
    for (std::size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += weight * part.values[i];
    total += weight * Sum(gauss) * Sum(gauss);
  }
  for (double& value : sum.values) value /= total;
  return sum;
}

std::vector<glm::dvec3> ResolvedColors(const Planes& planes, double pixels_per_degree) {
  const Plane y = FilterAsTheEye(planes[0], {{1.0, 0.0047}}, pixels_per_degree);
  const Plane cx = FilterAsTheEye(planes[1], {{1.0, 0.0053}}, pixels_per_degree);
  const Plane cz = FilterAsTheEye(planes[2], {{34.1, 0.04}, {13.5, 0.025}}, pixels_per_degree);
  std::vector<glm::dvec3> colors(y.values.size());
  for (std::size_t i = 0; i < colors.size(); ++i) {
    colors[i] = glm::clamp(YCxCzToLinear({y.values[i], cx.values[i], cz.values[i]}), 0.0, 1.0);
  }
  return colors;
}

// Positive weights sum up to 1, negative ones to -1.
Kernel Balance(Kernel kernel) {
  double positive = 0.0, negative = 0.0;
  for (const double value : kernel) (value > 0.0 ? positive : negative) += value;
  for (double& value : kernel) value /= value > 0.0 ? positive : -negative;
  return kernel;
}

struct Features {
  std::vector<double> edges, points;
};

// How much of an edge and of a point is at each pixel: norms of the first and second derivatives of a Gaussian.
Features FindFeatures(const Plane& lightness, double pixels_per_degree) {
  Plane unit = lightness;
  for (double& value : unit.values) value = (value + 16.0) / 116.0;
  const double sigma = 0.5 * kFeature_deg * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3.0 * sigma));
  const auto gauss = [&](double k) { return std::exp(-k * k / (2.0 * sigma * sigma)); };
  Kernel smooth = Sample(radius, gauss);
  const double total = Sum(smooth);
  for (double& value : smooth) value /= total;
  const auto norm = [&](const Kernel& kernel) {
    const Plane x = Filter(unit, kernel, smooth), y = Filter(unit, smooth, kernel);
    std::vector<double> norms(x.values.size());
    for (std::size_t i = 0; i < norms.size(); ++i) norms[i] = std::hypot(x.values[i], y.values[i]);
    return norms;
  };
  return {norm(Balance(Sample(radius, [&](double k) { return -k * gauss(k); }))),
          norm(Balance(Sample(radius, [&](double k) { return (k * k / (sigma * sigma) - 1.0) * gauss(k); })))};
}

}  // namespace

Measured<float> Flip(const Image& reference, const Image& test, double pixels_per_degree) {
  const Planes a = ToYCxCz(reference), b = ToYCxCz(test);
  const std::vector<glm::dvec3> colors_a = ResolvedColors(a, pixels_per_degree);
  const std::vector<glm::dvec3> colors_b = ResolvedColors(b, pixels_per_degree);
  const Features features_a = FindFeatures(a[0], pixels_per_degree), features_b = FindFeatures(b[0], pixels_per_degree);
  Measured<float> map(reference.width, reference.height);
  for (std::size_t i = 0; i < map.values.size(); ++i) {
    const double edge = std::abs(features_a.edges[i] - features_b.edges[i]);
    const double point = std::abs(features_a.points[i] - features_b.points[i]);
    const double feature = std::pow(std::max(edge, point) / std::sqrt(2.0), kQf);
    map.values[i] = static_cast<float>(std::pow(ColorError(colors_a[i], colors_b[i]), 1.0 - feature));
  }
  return map;
}

double Mean(const Measured<float>& map) {
  double sum = 0.0;
  for (const float value : map.values) sum += static_cast<double>(value);
  return map.values.empty() ? 0.0 : sum / static_cast<double>(map.values.size());
}

double Mean(const Measured<float>& map, const Measured<std::uint16_t>& mask) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < map.values.size() && i < mask.values.size(); ++i) {
    if (mask.values[i] == 0) continue;
    sum += static_cast<double>(map.values[i]);
    ++count;
  }
  return count == 0 ? 0.0 : sum / static_cast<double>(count);
}

}  // namespace picture
