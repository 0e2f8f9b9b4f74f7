#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace semmap {

// Shrinks 8-bit images of one size to another by bilinear interpolation, outer edges onto outer edges: the
// pixel at centre (x, y) shows (x + 0.5) * from / to - 0.5. Tables are made once. Factors of 1 to 2 along
// either side. Not thread-safe. Deterministic across CPUs.
class Downscaler {
 public:
  Downscaler(const cv::Size& from, const cv::Size& to);

  // `from` (CV_8UC1) has the size it was made for, `to` is filled in place.
  void Scale(const cv::Mat& from, cv::Mat* to);

 private:
  // Interpolates between source pixels `first` and first + 1.
  struct Tap {
    int first = 0;
    int second_weight = 0;  // of kUnit
  };
  // Eight neighbouring pixels of the result and the 16 source bytes that they come from, for one vector
  // shuffle.
  struct Octet {
    int base = 0;
    alignas(16) std::array<uint8_t, 16> shuffle{};
    alignas(16) std::array<uint8_t, 16> weights{};
  };

  static std::vector<Tap> MakeTaps(int from, int to);
  void MakeOctets();
  void ScaleRow(const uint8_t* from, uint8_t* to) const;

  cv::Size to_size_;
  std::vector<Tap> columns_;
  std::vector<Tap> rows_;
  std::vector<Octet> octets_;
  std::vector<uint8_t> row_;  // a row of the source height-wise interpolated, with room for vector loads
};

}  // namespace semmap
