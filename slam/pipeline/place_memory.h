#pragma once

#include <memory>
#include <optional>
#include <unordered_map>

#include "slam/map/keyframe.h"
#include "slam/pipeline/place_describer.h"
#include "slam/place/place_index.h"
#include "slam/place/vocabulary.h"
#include "slam/semantics/taxonomy.h"

namespace semmap {

// How the keyframes of one map look: the index that finds those like an image, and for each the keypoints by
// vocabulary node, for matching. Without a vocabulary it remembers nothing and finds nothing. Belongs to the
// map's owner; not thread-safe.
class PlaceMemory {
 public:
  // Keypoints of the classes in `inactive` say nothing about a place.
  PlaceMemory(std::shared_ptr<const Vocabulary> vocabulary, const PlaceQueryLimits& limits,
              const ClassSet& inactive = {});

  bool enabled() const { return index_.has_value(); }
  // This one and index() need a vocabulary.
  PlaceDescription Describe(const FrameFeatures& features) const { return describer_->Describe(features); }

  void Add(const KeyFrame& keyframe);
  void Remove(KeyFrameId id);
  void Clear();

  const PlaceIndex& index() const { return *index_; }
  // nullptr for keyframes that were not added.
  const BagOfWords* WordsOf(KeyFrameId id) const { return index_ ? index_->Find(id) : nullptr; }
  const DirectIndex* NodesOf(KeyFrameId id) const;

 private:
  std::optional<PlaceDescriber> describer_;
  std::optional<PlaceIndex> index_;
  std::unordered_map<KeyFrameId, DirectIndex, IdHash> nodes_;
};

}  // namespace semmap
