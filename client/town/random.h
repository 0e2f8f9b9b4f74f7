#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace semmap::town {

// SplitMix64 (Steele, Lea, Flood 2014). The town draws every number from such streams, each keyed by the seed
// and by what it is for, so that the same seed gives the same bytes on every platform and adding one thing
// does not move the others.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  // A stream of its own for one purpose and one or two indices of it.
  Random(uint64_t seed, uint64_t purpose, uint64_t index = 0, uint64_t sub_index = 0)
      : state_(Mix(Mix(Mix(Mix(seed) ^ purpose) ^ index) ^ sub_index)) {}

  uint64_t Next() {
    state_ += 0x9E3779B97F4A7C15ULL;
    return Finish(state_);
  }
  // [0, 1)
  double Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  float Float(double low, double high) { return static_cast<float>(Uniform(low, high)); }
  // [0, count), count > 0
  int Below(int count) { return static_cast<int>(Next() % static_cast<uint64_t>(count)); }
  // [low, high]
  int Integer(int low, int high) { return low + Below(high - low + 1); }
  bool Chance(double probability) { return Uniform() < probability; }
  // Normal distribution of mean 0 and deviation 1 (Box and Muller 1958).
  double Normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
    return radius * std::cos(2.0 * 3.14159265358979323846 * Uniform());
  }
  template <typename T>
  const T& Pick(const std::vector<T>& from) {
    return from[static_cast<size_t>(Below(static_cast<int>(from.size())))];
  }

 private:
  static uint64_t Finish(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  static uint64_t Mix(uint64_t value) { return Finish(value + 0x9E3779B97F4A7C15ULL); }

  uint64_t state_;
};

}  // namespace semmap::town
