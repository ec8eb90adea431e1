#include "tools/bench/chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace bench {
namespace {

constexpr double kWidth = 520.0, kHeight = 330.0;                           // of a panel
constexpr double kLeft = 70.0, kRight = 20.0, kTop = 34.0, kBottom = 50.0;  // margins of its plot
constexpr double kLetter = 6.2, kLine = 12.0;                               // of text of 11 px
constexpr std::size_t kMostMarks = 40;                                      // of a line
constexpr std::array<const char*, 8> kColours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                 "#B8860B", "#3A9BD0", "#000000", "#7F7F7F"};  // after Okabe and Ito

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

std::string Text(double x, double y, const char* anchor, const std::string& text, const char* more = "") {
  return Format("<text x='%.1f' y='%.1f' text-anchor='%s' %s>", x, y, anchor, more) + Escape(text) + "</text>\n";
}

std::string TickText(double value) {
  if (value >= 1e6) return Format("%gM", value * 1e-6);
  if (value >= 1e4) return Format("%gk", value * 1e-3);
  return Format("%g", value);
}

struct Axis {
  double low = 0.0, high = 1.0;
  bool is_log = true;

  [[nodiscard]] double At(double value) const {
    if (!is_log) return std::clamp((value - low) / (high - low), 0.0, 1.0);
    if (!(value > 0.0)) return 0.0;
    return std::clamp(std::log(value / low) / std::log(high / low), 0.0, 1.0);
  }
  [[nodiscard]] std::vector<double> Ticks() const {
    std::vector<double> ticks;
    if (!is_log) {
      const double raw = (high - low) / 5.0;
      const double power = std::pow(10.0, std::floor(std::log10(raw)));
      const double step = raw / power < 1.5 ? power : raw / power < 3.5 ? 2.0 * power : 5.0 * power;
      // Whole numbers of steps: sums of steps would pass zero at -0 or 1e-17.
      const auto first = static_cast<int>(std::ceil(low / step));
      const auto last = static_cast<int>(std::floor(high * 1.0001 / step));
      for (int i = first; i <= last; ++i) ticks.push_back(i * step);
      return ticks;
    }
    const double decades = std::log10(high / low);
    for (int e = static_cast<int>(std::floor(std::log10(low))); e <= std::ceil(std::log10(high)); ++e) {
      for (const double digit : {1.0, 2.0, 5.0}) {
        const double t = digit * std::pow(10.0, e);
        if ((digit > 1.0 && decades > 2.2) || t < low * 0.999 || t > high * 1.001) continue;
        ticks.push_back(t);
      }
    }
    return ticks;
  }
};

Axis Span(std::vector<double> values, bool is_log) {
  double low = 1e300;
  double high = -1e300;
  for (const double v : values) {
    if (!std::isfinite(v) || (is_log && v <= 0.0)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  if (high < low) return {is_log ? 0.1 : 0.0, 1.0, is_log};
  if (!is_log && values.size() > kMostMarks && low > 0.5 * high && high > low)
    return {low - 0.1 * (high - low), high + 0.1 * (high - low) + 1e-12, false};
  if (!is_log) return {std::min(0.0, low), high > 0.0 ? 1.12 * high : 1.0, false};
  const double room = std::max(1.25, std::pow(high / low, 0.06));
  return {low / room, high * room, true};
}

std::string Mark(std::size_t series, double x, double y, const std::string& tip) {
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
  return shape + "<title>" + Escape(tip) + "</title>" + end + "\n";
}

struct Box {
  double x0, y0, x1, y1;
};

// Finds places for texts beside points where they cover neither a mark nor each other.
class Labels {
 public:
  explicit Labels(const Box& plot) : plot_(plot) {}
  void Occupy(double x, double y) { taken_.push_back({x - 5, y - 5, x + 5, y + 5}); }
  std::string Place(double x, double y, const std::string& text, const char* colour, bool is_bold) {
    const double width = (is_bold ? 1.28 : 0.95) * kLetter * static_cast<double>(text.size());
    for (const double away : {0.0, 11.0, 22.0, 36.0, 52.0}) {
      for (const auto& [dx, dy] : {std::pair{8.0, 4.0},
                                   {-8.0 - width, 4.0},
                                   {-0.5 * width, -8.0},
                                   {-0.5 * width, 16.0},
                                   {7.0, -7.0},
                                   {7.0, 15.0},
                                   {-7.0 - width, -7.0},
                                   {-7.0 - width, 15.0}}) {
        const double left = x + dx + (dx > 0 ? 0.4 : -0.4) * away;
        const double base = y + dy + (dy > 4.0 ? 1.0 : dy < 4.0 ? -1.0 : 0.0) * away;
        const Box box{left, base - 9.0, left + width, base + 2.0};
        if (box.x0 < plot_.x0 || box.x1 > plot_.x1 || box.y0 < plot_.y0 || box.y1 > plot_.y1) continue;
        if (std::any_of(taken_.begin(), taken_.end(), [&](const Box& b) {
              return box.x0 < b.x1 && b.x0 < box.x1 && box.y0 < b.y1 && b.y0 < box.y1;
            })) {
          continue;
        }
        taken_.push_back(box);
        return Format(
                   "<text x='%.1f' y='%.1f' fill='%s' font-size='%d' stroke='white' stroke-width='3' "
                   "paint-order='stroke'%s>",
                   left, base, colour, is_bold ? 12 : 10, is_bold ? " font-weight='bold'" : "") +
               Escape(text) + "</text>\n";
      }
    }
    return "";  // no room: the legend and the tooltip name the point
  }

 private:
  Box plot_;
  std::vector<Box> taken_;
};

std::size_t IndexOf(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::string DrawFrame(const Panel& panel, double x0, double y0, double w, double h) {
  std::string svg = Text(x0, y0 - 12, "start", panel.title, "font-weight='bold' font-size='13'");
  svg += Format("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='none' stroke='#888'/>\n", x0, y0, w, h);
  svg += Text(x0 + w / 2, y0 + h + 36, "middle", panel.x_title);
  return svg;
}

std::string DrawPoints(const Panel& panel, const std::vector<std::string>& names, double left, double top) {
  const double w = kWidth - kLeft - kRight;
  const double h = kHeight - kTop - kBottom;
  const double x0 = left + kLeft;
  const double y0 = top + kTop;
  std::vector<double> xs, ys;
  for (const Series& series : panel.series) {
    for (const ChartPoint& p : series.points) {
      xs.insert(xs.end(), {p.x, p.x_high, p.x_tick});
      ys.push_back(p.y);
    }
  }
  const Axis x_axis = Span(xs, panel.x_log);
  Axis y_axis = Span(ys, panel.y_log);
  if (std::isfinite(panel.y_low)) y_axis.low = panel.y_low;
  if (std::isfinite(panel.y_high)) y_axis.high = panel.y_high;
  const auto X = [&](double v) { return x0 + w * x_axis.At(v); };
  const auto Y = [&](double v) { return y0 + h * (1.0 - y_axis.At(v)); };
  std::string svg;
  for (const Band& band : panel.bands) {
    const double above = Y(band.y_high);
    svg += Format("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='#fbe3dd'/>", x0, above, w,
                  std::max(0.0, Y(band.y_low) - above));
    svg += Text(x0 + 6, above + 13, "start", band.label, "fill='#a33' font-size='10'");
  }
  for (const double t : x_axis.Ticks()) {
    svg += Format("<path d='M%.1f %.1fv%.1f' stroke='#e4e4e4'/>", X(t), y0, h);
    svg += Text(X(t), y0 + h + 16, "middle", TickText(t));
  }
  for (const double t : y_axis.Ticks()) {
    svg += Format("<path d='M%.1f %.1fh%.1f' stroke='#e4e4e4'/>", x0, Y(t), w);
    svg += Text(x0 - 6, Y(t) + 4, "end", TickText(t));
  }
  svg += DrawFrame(panel, x0, y0, w, h);
  svg += Format("<text transform='translate(%.1f %.1f) rotate(-90)' text-anchor='middle'>", left + 16, y0 + h / 2) +
         Escape(panel.y_title) + "</text>\n";
  Labels labels({x0 + 1, y0 + 1, x0 + w - 1, y0 + h - 1});
  std::string marks;
  for (const Series& series : panel.series) {
    const std::size_t index = IndexOf(names, series.name);
    const char* colour = kColours[index % kColours.size()];
    std::vector<ChartPoint> points = series.points;
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
    std::string path;
    for (const ChartPoint& p : points) {
      path += Format("%s%.1f %.1f", path.empty() ? "M" : "L", X(p.x), Y(p.y));
      if (std::isfinite(p.x_high)) {
        svg += Format("<path d='M%.1f %.1fH%.1f' stroke='%s' opacity='0.6'/>", X(p.x), Y(p.y), X(p.x_high), colour);
      }
      if (std::isfinite(p.x_tick)) {
        svg += Format("<path d='M%.1f %.1fv6' stroke='%s' opacity='0.6'/>", X(p.x_tick), Y(p.y) - 3, colour);
      }
      if (points.size() > kMostMarks) continue;
      marks += Mark(index, X(p.x), Y(p.y),
                    series.name + (p.mark.empty() ? "" : ", " + p.mark) + Format(": %.4g, %.4g", p.x, p.y));
      labels.Occupy(X(p.x), Y(p.y));
    }
    if (series.is_line) svg += "<path d='" + path + Format("' fill='none' stroke='%s' stroke-width='1.6'/>\n", colour);
  }
  svg += marks;
  for (const Series& series : panel.series) {
    if (series.points.empty()) continue;
    const char* colour = kColours[IndexOf(names, series.name) % kColours.size()];
    const auto plain = std::find_if(series.points.begin(), series.points.end(), [](auto& p) { return p.mark.empty(); });
    const ChartPoint& at = series.is_line || plain == series.points.end() ? series.points.back() : *plain;
    svg += labels.Place(X(at.x), Y(at.y), series.name, colour, true);
  }
  for (const Series& series : panel.series) {
    const char* colour = kColours[IndexOf(names, series.name) % kColours.size()];
    for (const ChartPoint& p : series.points) {
      if (!p.mark.empty()) svg += labels.Place(X(p.x), Y(p.y), p.mark, colour, false);
    }
  }
  return svg;
}

std::string DrawBars(const Panel& panel, const std::vector<std::string>& names, double left, double top) {
  std::size_t longest = 0;
  std::vector<double> values;
  for (const Bar& bar : panel.bars) {
    longest = std::max(longest, bar.label.size());
    values.push_back(bar.value);
  }
  const double x0 = left + 16.0 + kLetter * static_cast<double>(longest);
  const double y0 = top + kTop;
  const double w = left + kWidth - 70.0 - x0;
  const double h = kHeight - kTop - kBottom;
  Axis axis = Span(values, panel.x_log);
  if (panel.x_log) axis.low = std::min(axis.low, 1.0);
  const double step = h / static_cast<double>(panel.bars.size());
  std::string svg;
  for (const double t : axis.Ticks()) {
    svg += Format("<path d='M%.1f %.1fv%.1f' stroke='#e4e4e4'/>", x0 + w * axis.At(t), y0, h);
    svg += Text(x0 + w * axis.At(t), y0 + h + 16, "middle", TickText(t));
  }
  for (std::size_t i = 0; i < panel.bars.size(); ++i) {
    const Bar& bar = panel.bars[i];
    const double y = y0 + step * static_cast<double>(i);
    const double length = w * axis.At(bar.value);
    svg += Format("<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='%s'/>", x0, y + 0.15 * step, length,
                  0.7 * step, kColours[IndexOf(names, bar.series) % kColours.size()]);
    svg += Text(x0 - 6, y + 0.5 * step + 4, "end", bar.label);
    svg += Text(x0 + length + 5, y + 0.5 * step + 4, "start", bar.note);
  }
  return svg + DrawFrame(panel, x0, y0, w, h);
}

}  // namespace

std::string DrawSvg(const Chart& chart) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const Panel& panel : chart.panels) {
    for (const Series& series : panel.series) add(series.name);
    for (const Bar& bar : panel.bars) add(bar.series);
  }
  const bool is_single = chart.panels.size() == 1;
  const double width = is_single ? std::max({kWidth, 40.0 + 9.0 * static_cast<double>(chart.title.size()),
                                             40.0 + 6.4 * static_cast<double>(chart.subtitle.size())})
                                 : 2 * kWidth;
  const double height = 72.0 + std::ceil(static_cast<double>(chart.panels.size()) / 2.0) * kHeight;
  std::string svg = Format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %g %g' width='%g' height='%g' "
      "font-family='DejaVu Sans, sans-serif' font-size='11'>\n<rect width='100%%' height='100%%' "
      "fill='white'/>\n",
      width, height, width, height);
  svg += Text(14, 22, "start", chart.title, "font-size='14' font-weight='bold'");
  svg += Text(14, 40, "start", chart.subtitle, "fill='#555'");
  double x = 20.0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    svg += Mark(i, x, 58.0, names[i]) + Text(x + 10, 62, "start", names[i]);
    x += 34.0 + 7.0 * static_cast<double>(names[i].size());
  }
  for (std::size_t i = 0; i < chart.panels.size(); ++i) {
    const double left = kWidth * static_cast<double>(i % 2);
    const double top = 68.0 + kHeight * static_cast<double>(i / 2);
    svg += chart.panels[i].bars.empty() ? DrawPoints(chart.panels[i], names, left, top)
                                        : DrawBars(chart.panels[i], names, left, top);
  }
  return svg + "</svg>\n";
}

}  // namespace bench
