#pragma once

namespace muscle {

// A filter of second order,
//   y_k = b0 x_k + b1 x_(k-1) + b2 x_(k-2) - a1 y_(k-1) - a2 y_(k-2).
class Biquad {
 public:
  // Butterworth's, by the bilinear transform with the corner where it is wanted; `sample_s` apart.
  static Biquad LowPass(double corner_Hz, double sample_s);
  static Biquad HighPass(double corner_Hz, double sample_s);

  double Step(double x) {
    const double y = b0_ * x + s1_;  // transposed direct form II
    s1_ = b1_ * x - a1_ * y + s2_;
    s2_ = b2_ * x - a2_ * y;
    return y;
  }

 private:
  double b0_ = 1.0, b1_ = 0.0, b2_ = 0.0, a1_ = 0.0, a2_ = 0.0;
  double s1_ = 0.0, s2_ = 0.0;
};

}  // namespace muscle
