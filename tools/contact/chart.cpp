#include "tools/contact/chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace contact {
namespace {

constexpr double kWidth = 430.0, kHeight = 260.0;                           // of a panel
constexpr double kLeft = 62.0, kRight = 14.0, kTop = 30.0, kBottom = 44.0;  // margins of its plot
constexpr std::array<const char*, 8> kColours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                 "#E69F00", "#56B4E9", "#000000", "#7F7F7F"};  // Okabe and Ito

std::string Escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

template <typename... T>
std::string Format(const char* format, T... values) {
  char text[512];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

// Whole decades around the positive values.
struct Axis {
  int low = 0, high = 1;
  [[nodiscard]] double At(double value) const {
    return value > 0.0 ? std::clamp((std::log10(value) - low) / (high - low), 0.0, 1.0) : 0.0;
  }
};

Axis Span(const Panel& panel, double ChartPoint::*member) {
  double low = 1e300;
  double high = 0.0;
  for (const Series& series : panel.series) {
    for (const ChartPoint& point : series.points) {
      if (!(point.*member > 0.0)) continue;
      low = std::min(low, point.*member);
      high = std::max(high, point.*member);
    }
  }
  if (high <= 0.0) return {};
  Axis axis{static_cast<int>(std::floor(std::log10(low))), static_cast<int>(std::ceil(std::log10(high)))};
  if (axis.high <= axis.low) axis.high = axis.low + 1;
  return axis;
}

std::string Mark(std::size_t series, double x, double y, const std::string& label) {
  const char* colour = kColours[series % kColours.size()];
  std::string shape;
  switch (series % 4) {
    case 0:
      shape = Format("<circle cx='%.1f' cy='%.1f' r='4.5' fill='%s'>", x, y, colour);
      break;
    case 1:
      shape = Format("<rect x='%.1f' y='%.1f' width='8' height='8' fill='%s'>", x - 4, y - 4, colour);
      break;
    case 2:
      shape = Format("<path d='M%.1f %.1fl5 9h-10z' fill='%s'>", x, y - 5.5, colour);
      break;
    default:
      shape = Format("<path d='M%.1f %.1fl5 5l-5 5l-5-5z' fill='%s'>", x, y - 5, colour);
  }
  const char* end = series % 4 == 0 ? "</circle>" : series % 4 == 1 ? "</rect>" : "</path>";
  return shape + "<title>" + Escape(label) + "</title>" + end + "\n";
}

std::string DrawPanel(const Panel& panel, const std::vector<std::string>& names, double x0, double y0) {
  const Axis x_axis = Span(panel, &ChartPoint::x);
  const Axis y_axis = Span(panel, &ChartPoint::y);
  const double w = kWidth - kLeft - kRight;
  const double h = kHeight - kTop - kBottom;
  const auto X = [&](double v) { return x0 + kLeft + w * x_axis.At(v); };
  const auto Y = [&](double v) { return y0 + kTop + h * (1.0 - y_axis.At(v)); };
  std::string svg = Format("<text x='%.1f' y='%.1f' font-weight='bold'>", x0 + kLeft, y0 + kTop - 10) +
                    Escape(panel.title) + "</text>\n";
  for (int e = x_axis.low; e <= x_axis.high; ++e) {
    const double x = X(std::pow(10.0, e));
    svg += Format("<path d='M%.1f %.1fv%.1f' stroke='#ddd'/>", x, y0 + kTop, h);
    svg += Format("<text x='%.1f' y='%.1f' text-anchor='middle'>%g</text>\n", x, y0 + kTop + h + 15, std::pow(10.0, e));
  }
  for (int e = y_axis.low; e <= y_axis.high; ++e) {
    const double y = Y(std::pow(10.0, e));
    svg += Format("<path d='M%.1f %.1fh%.1f' stroke='#ddd'/>", x0 + kLeft, y, w);
    svg += Format("<text x='%.1f' y='%.1f' text-anchor='end'>%g</text>\n", x0 + kLeft - 6, y + 4, std::pow(10.0, e));
  }
  svg += Format("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='none' stroke='#888'/>\n", x0 + kLeft,
                y0 + kTop, w, h);
  svg += Format("<text x='%.1f' y='%.1f' text-anchor='middle'>", x0 + kLeft + w / 2, y0 + kTop + h + 32) +
         Escape(panel.x_title) + "</text>\n";
  for (const Series& series : panel.series) {
    const auto index = static_cast<std::size_t>(std::find(names.begin(), names.end(), series.name) - names.begin());
    std::vector<ChartPoint> points = series.points;
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
    for (const ChartPoint& p : points) svg += Mark(index, X(p.x), Y(p.y), series.name + ", " + p.label);
  }
  return svg;
}

}  // namespace

std::string DrawSvg(const Chart& chart) {
  std::vector<std::string> names;
  for (const Panel& panel : chart.panels) {
    for (const Series& series : panel.series) {
      if (std::find(names.begin(), names.end(), series.name) == names.end()) names.push_back(series.name);
    }
  }
  const double rows = std::ceil(static_cast<double>(chart.panels.size()) / 2.0);
  const double width = 2.0 * kWidth;
  const double height = 62.0 + rows * kHeight;
  std::string svg = Format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %g %g' width='%g' height='%g' "
      "font-family='DejaVu Sans, sans-serif' font-size='11'>\n<rect width='100%%' height='100%%' "
      "fill='white'/>\n",
      width, height, width, height);
  svg += "<text x='14' y='22' font-size='14' font-weight='bold'>" + Escape(chart.title) + "</text>\n";
  double x = 24.0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    svg += Mark(i, x, 42.0, names[i]);
    svg += Format("<text x='%.1f' y='46'>", x + 10) + Escape(names[i]) + "</text>\n";
    x += 34.0 + 7.0 * static_cast<double>(names[i].size());
  }
  for (std::size_t i = 0; i < chart.panels.size(); ++i) {
    svg += DrawPanel(chart.panels[i], names, kWidth * static_cast<double>(i % 2),
                     58.0 + kHeight * static_cast<double>(i / 2));
  }
  return svg + "</svg>\n";
}

}  // namespace contact
