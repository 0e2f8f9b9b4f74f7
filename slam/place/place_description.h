#pragma once

#include <cstdint>
#include <vector>

namespace semmap {

// A leaf of the vocabulary's tree, 0 to words - 1.
using WordId = uint32_t;

struct WordWeight {
  WordId word = 0;
  float weight = 0;

  friend bool operator==(const WordWeight&, const WordWeight&) = default;
};

// What an image shows, as words: sorted by word, each at most once, with tf-idf weights above zero whose sum
// is 1 (Sivic and Zisserman, Video Google, ICCV 2003). Empty for an image without features.
using BagOfWords = std::vector<WordWeight>;

// The keypoints keypoints[begin, end) of a DirectIndex, all below one node.
struct NodeGroup {
  uint32_t node = 0;
  uint32_t begin = 0;
  uint32_t end = 0;

  friend bool operator==(const NodeGroup&, const NodeGroup&) = default;
};

// Which keypoints fell below which node of one level of the tree (the direct index of Galvez-Lopez and
// Tardos, Bags of Binary Words, T-RO 2012, section IV-C). Descriptors of one corner in two images mostly fall
// below the same node, so that matching needs to compare only within nodes that both images have.
struct DirectIndex {
  std::vector<NodeGroup> groups;    // sorted by node; every keypoint is in exactly one
  std::vector<uint32_t> keypoints;  // positions among the image's descriptors, rising within a group

  friend bool operator==(const DirectIndex&, const DirectIndex&) = default;
};

struct PlaceDescription {
  BagOfWords words;
  DirectIndex nodes;

  friend bool operator==(const PlaceDescription&, const PlaceDescription&) = default;
};

// 1 - 0.5 |a - b|_1 (Galvez-Lopez and Tardos 2012, equation 1), in [0, 1] up to rounding: 1 for equal bags, 0
// for bags without a common word and when one of them is empty.
double Similarity(const BagOfWords& a, const BagOfWords& b);

}  // namespace semmap
