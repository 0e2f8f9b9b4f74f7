#include "client/town/curve.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

namespace semmap::town {
namespace {
constexpr double kSamePoint = 1e-6;
}

Path::Path(std::vector<glm::dvec2> points) : points_(std::move(points)) { Measure(); }

void Path::Measure() {
  lengths_.assign(points_.size(), 0.0);
  for (size_t i = 1; i < points_.size(); ++i) {
    lengths_[i] = lengths_[i - 1] + glm::distance(points_[i - 1], points_[i]);
  }
  tangents_.resize(points_.size());
  for (size_t i = 0; i < points_.size(); ++i) {
    const size_t before = i == 0 ? 0 : i - 1;
    const size_t after = std::min(i + 1, points_.size() - 1);
    tangents_[i] = glm::normalize(points_[after] - points_[before]);
  }
}

size_t Path::SegmentAt(double s) const {
  const auto above = std::upper_bound(lengths_.begin(), lengths_.end(), s);
  const auto index = static_cast<size_t>(std::distance(lengths_.begin(), above));
  return std::clamp<size_t>(index, 1, points_.size() - 1) - 1;
}

glm::dvec2 Path::PointAt(double s) const {
  s = std::clamp(s, 0.0, length());
  const size_t i = SegmentAt(s);
  const double t = (s - lengths_[i]) / (lengths_[i + 1] - lengths_[i]);
  return points_[i] + (points_[i + 1] - points_[i]) * t;
}

glm::dvec2 Path::TangentAt(double s) const {
  s = std::clamp(s, 0.0, length());
  const size_t i = SegmentAt(s);
  const double t = (s - lengths_[i]) / (lengths_[i + 1] - lengths_[i]);
  return glm::normalize(tangents_[i] + (tangents_[i + 1] - tangents_[i]) * t);
}

glm::dvec2 Path::LeftAt(double s) const {
  const glm::dvec2 tangent = TangentAt(s);
  return {-tangent.y, tangent.x};
}

double Path::CurvatureAt(double s) const {
  const double from = std::max(0.0, s - 1.0);
  const double to = std::min(length(), s + 1.0);
  if (to - from < 0.1) return 0.0;
  const glm::dvec2 a = TangentAt(from);
  const glm::dvec2 b = TangentAt(to);
  return std::atan2(a.x * b.y - a.y * b.x, glm::dot(a, b)) / (to - from);
}

Path Path::Offset(double lateral) const {
  std::vector<glm::dvec2> moved(points_.size());
  for (size_t i = 0; i < points_.size(); ++i) {
    moved[i] = points_[i] + glm::dvec2(-tangents_[i].y, tangents_[i].x) * lateral;
  }
  return Path(std::move(moved));
}

Path Path::Reversed() const { return Path({points_.rbegin(), points_.rend()}); }

Path Path::Slice(double from, double to) const {
  from = std::clamp(from, 0.0, length());
  to = std::clamp(to, from, length());
  std::vector<glm::dvec2> part = {PointAt(from)};
  for (size_t i = 0; i < points_.size(); ++i) {
    if (lengths_[i] > from + kSamePoint && lengths_[i] < to - kSamePoint) part.push_back(points_[i]);
  }
  part.push_back(PointAt(to));
  return Path(std::move(part));
}

void Path::Append(const Path& next) {
  for (const glm::dvec2& point : next.points_) {
    if (points_.empty() || glm::distance(points_.back(), point) > kSamePoint) points_.push_back(point);
  }
  Measure();
}

double Path::Project(const glm::dvec2& point) const {
  double best = 0.0;
  double best_distance = 1e300;
  for (size_t i = 0; i + 1 < points_.size(); ++i) {
    const glm::dvec2 along = points_[i + 1] - points_[i];
    const double t = std::clamp(glm::dot(point - points_[i], along) / glm::dot(along, along), 0.0, 1.0);
    const double distance = glm::distance(point, points_[i] + along * t);
    if (distance < best_distance) {
      best_distance = distance;
      best = lengths_[i] + t * (lengths_[i + 1] - lengths_[i]);
    }
  }
  return best;
}

std::vector<glm::dvec2> SampleCubic(glm::dvec2 p0, glm::dvec2 p1, glm::dvec2 p2, glm::dvec2 p3, double step) {
  const double control_length = glm::distance(p0, p1) + glm::distance(p1, p2) + glm::distance(p2, p3);
  const int count = std::max(4, static_cast<int>(std::ceil(control_length / step)));
  std::vector<glm::dvec2> points;
  points.reserve(static_cast<size_t>(count) + 1);
  for (int i = 0; i <= count; ++i) {
    const double t = static_cast<double>(i) / count;
    const double u = 1.0 - t;
    points.push_back(u * u * u * p0 + 3.0 * u * u * t * p1 + 3.0 * u * t * t * p2 + t * t * t * p3);
  }
  return points;
}

std::vector<glm::dvec2> SampleQuadratic(glm::dvec2 p0, glm::dvec2 p1, glm::dvec2 p2, int count) {
  std::vector<glm::dvec2> points;
  points.reserve(static_cast<size_t>(count) + 1);
  for (int i = 0; i <= count; ++i) {
    const double t = static_cast<double>(i) / count;
    const double u = 1.0 - t;
    points.push_back(u * u * p0 + 2.0 * u * t * p1 + t * t * p2);
  }
  return points;
}

}  // namespace semmap::town
