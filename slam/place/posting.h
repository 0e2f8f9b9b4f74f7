#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace semmap {

// An entry of the inverted index: a keyframe's slot and its weight of the word, in 32 bits. The weight is
// rounded up to the next of 256 steps of 1/16 octave (4.4 %), so that what is added up from postings is an
// upper bound of the similarity. Postings sort by slot.
class Posting {
 public:
  static constexpr uint32_t kMaxSlots = 1U << 24U;

  Posting(uint32_t slot, float weight) : bits_((slot << 8U) | CodeOf(weight)) {}

  uint32_t slot() const { return bits_ >> 8U; }
  // At least the weight that was put in; weights below 2^-15.9 count as that.
  float weight() const { return kWeights[bits_ & 0xFFU]; }

  friend bool operator==(Posting, Posting) = default;

 private:
  static constexpr int kStepsPerOctave = 16;

  static std::array<float, 256> Weights() {
    std::array<float, 256> weights;
    for (int code = 0; code < 256; ++code) {
      weights[code] = static_cast<float>(std::exp2(double{code - 255.0} / kStepsPerOctave));
    }
    return weights;
  }
  static uint32_t CodeOf(float weight) {
    // The logarithm may be off by its rounding: one step at most.
    const float steps =
        std::ceil(static_cast<float>(kStepsPerOctave) * std::log2(std::max(weight, kWeights[0])));
    auto code = static_cast<uint32_t>(std::clamp(255 + static_cast<int>(steps), 0, 255));
    while (code < 255 && kWeights[code] < weight) ++code;
    while (code > 0 && kWeights[code - 1] >= weight) --code;
    return code;
  }

  inline static const std::array<float, 256> kWeights = Weights();

  uint32_t bits_;
};

}  // namespace semmap
