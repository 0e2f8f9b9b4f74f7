#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace semmap {

// An integer that cannot be mixed up with another kind of id. Value 0 means "none", so that a packed
// array of ids can say "nothing here" without a second array.
template <typename Tag>
class StrongId {
 public:
  using ValueType = uint64_t;

  constexpr StrongId() = default;
  constexpr explicit StrongId(ValueType value) : value_(value) {}

  constexpr ValueType value() const { return value_; }
  constexpr bool IsValid() const { return value_ != 0; }

  friend constexpr auto operator<=>(StrongId, StrongId) = default;

 private:
  ValueType value_ = 0;
};

// Ids are unique within one map and never used again, not even after the thing was culled.
using KeyFrameId = StrongId<struct KeyFrameIdTag>;
using MapPointId = StrongId<struct MapPointIdTag>;

// Ids are handed out one after the other, so the identity is a good hash, and (unlike a salted one) it
// gives the same iteration order in every run: results stay reproducible.
struct IdHash {
  template <typename Tag>
  size_t operator()(StrongId<Tag> id) const {
    return static_cast<size_t>(id.value());
  }
};

}  // namespace semmap
