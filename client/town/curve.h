#pragma once

#include <vector>

#include <glm/vec2.hpp>

namespace semmap::town {

// A plane curve known by closely spaced points and walked by its arc length, metres. At least two points,
// apart.
class Path {
 public:
  Path() = default;
  explicit Path(std::vector<glm::dvec2> points);

  double length() const { return lengths_.empty() ? 0.0 : lengths_.back(); }
  bool empty() const { return points_.empty(); }
  const std::vector<glm::dvec2>& points() const { return points_; }

  // `s` outside [0, length] is clamped.
  glm::dvec2 PointAt(double s) const;
  // Unit tangent, continuous along the curve.
  glm::dvec2 TangentAt(double s) const;
  // Unit normal to the left of the direction of travel.
  glm::dvec2 LeftAt(double s) const;
  // Signed curvature, 1/m, positive to the left; averaged over two metres.
  double CurvatureAt(double s) const;
  // The point `lateral` metres to the left.
  glm::dvec2 OffsetPoint(double s, double lateral) const { return PointAt(s) + LeftAt(s) * lateral; }

  // The parallel curve `lateral` metres to the left.
  Path Offset(double lateral) const;
  Path Reversed() const;
  Path Slice(double from, double to) const;
  // Joins `next` to the end; its first point is dropped when it repeats this curve's last.
  void Append(const Path& next);
  // Arc length of the point nearest to `point`.
  double Project(const glm::dvec2& point) const;

 private:
  void Measure();
  size_t SegmentAt(double s) const;

  std::vector<glm::dvec2> points_;
  std::vector<glm::dvec2> tangents_;
  std::vector<double> lengths_;
};

// Samples of a cubic Bezier curve about `step` metres apart, both ends included.
std::vector<glm::dvec2> SampleCubic(glm::dvec2 p0, glm::dvec2 p1, glm::dvec2 p2, glm::dvec2 p3, double step);
// `count` + 1 samples of a quadratic Bezier curve.
std::vector<glm::dvec2> SampleQuadratic(glm::dvec2 p0, glm::dvec2 p1, glm::dvec2 p2, int count);

}  // namespace semmap::town
