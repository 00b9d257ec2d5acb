#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace lsmvs {

// Small deterministic generator (splitmix64), the same on every machine and with every standard
// library. A generator of (seed, stream) is independent of that of another stream: one stream an
// item keeps parallel loops deterministic.
class Random {
 public:
  explicit Random(uint64_t seed, uint64_t stream = 0) : state_(Mix(seed) ^ Mix(~stream)) {}

  uint64_t Bits() { return Mix(state_ += 0x9e3779b97f4a7c15u); }
  // In [0, 1).
  double Uniform() { return static_cast<double>(Bits() >> 11) * 0x1p-53; }
  double Uniform(double min, double max) { return min + (max - min) * Uniform(); }
  // In [0, count).
  uint64_t Below(uint64_t count) { return Bits() % count; }
  // Normal distribution of mean 0 and standard deviation 1.
  double Gaussian() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * Uniform());
  }
  Eigen::Vector3d Gaussian3() {
    const double x = Gaussian(), y = Gaussian();
    return {x, y, Gaussian()};
  }

  static uint64_t Mix(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }

 private:
  uint64_t state_;
};

}  // namespace lsmvs
