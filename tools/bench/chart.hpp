#pragma once

#include <limits>
#include <string>
#include <vector>

namespace bench {

struct ChartPoint {
  double x = 0.0, y = 0.0;
  std::string mark;  // small text beside it; empty: none, and the series' name may be placed here
  // A whisker to the right, with a tick at its end; NaN: none.
  double x_high = std::numeric_limits<double>::quiet_NaN();
  double x_tick = std::numeric_limits<double>::quiet_NaN();
};

struct Series {
  std::string name;
  std::vector<ChartPoint> points;
  bool is_line = true;  // joined in the order of x
};

struct Bar {
  std::string label;
  double value = 0.0;
  std::string note;    // at the bar's end
  std::string series;  // its colour
};

// A tinted band over the plot's whole width, for example where a goal fails.
struct Band {
  double y_low = 0.0, y_high = 0.0;  // may reach beyond the axis
  std::string label;
};

// Either points or bars.
struct Panel {
  std::string title;
  std::string x_title;
  std::string y_title;
  std::vector<Series> series;
  bool x_log = true, y_log = true;  // logarithmic axes show positive values only; linear ones begin at 0
                                    // unless all values are near each other
  std::vector<Bar> bars;            // along x
  std::vector<Band> bands{};
  // Ends of the y axis; NaN: chosen from the values. Points beyond are drawn at the border.
  double y_low = std::numeric_limits<double>::quiet_NaN();
  double y_high = std::numeric_limits<double>::quiet_NaN();
};

struct Chart {
  std::string title;
  std::string subtitle;
  std::vector<Panel> panels;  // two a row
};

// Draws the chart as SVG text. A series has one colour and one mark in all panels, and its name beside one of its
// points.
std::string DrawSvg(const Chart& chart);

}  // namespace bench
