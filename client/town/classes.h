#pragma once

#include "slam/semantics/taxonomy.h"

namespace semmap::town {

// The labels of the class mask.
using ClassId = SemanticClass;

inline constexpr int kClassCount = kSemanticClassCount;
inline constexpr const auto& kClasses = kSemanticClasses;

}  // namespace semmap::town
