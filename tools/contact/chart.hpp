#pragma once

#include <string>
#include <vector>

namespace contact {

struct ChartPoint {
  double x = 0.0, y = 0.0;  // both axes are logarithmic: points that are not positive are drawn at the lower border
  std::string label;        // shown when the pointer rests on it
};

struct Series {
  std::string name;
  std::vector<ChartPoint> points;
};

struct Panel {
  std::string title;
  std::string x_title;
  std::vector<Series> series;
};

struct Chart {
  std::string title;
  std::vector<Panel> panels;  // two a row
};

// A picture as SVG text. A series has one colour and one mark in all panels.
std::string DrawSvg(const Chart& chart);

}  // namespace contact
