#pragma once

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

// Returns from the calling function when `expr` (an absl::Status) is not OK.
#define SEMMAP_RETURN_IF_ERROR(expr)               \
  do {                                             \
    absl::Status semmap_status = (expr);           \
    if (!semmap_status.ok()) return semmap_status; \
  } while (false)

#define SEMMAP_CONCAT_INNER(a, b) a##b
#define SEMMAP_CONCAT(a, b) SEMMAP_CONCAT_INNER(a, b)

// Declares or assigns `lhs` from `expr` (an absl::StatusOr), or returns its status.
#define SEMMAP_ASSIGN_OR_RETURN(lhs, expr) \
  SEMMAP_ASSIGN_OR_RETURN_IMPL(SEMMAP_CONCAT(semmap_or_, __LINE__), lhs, expr)
#define SEMMAP_ASSIGN_OR_RETURN_IMPL(result, lhs, expr) \
  auto result = (expr);                                 \
  if (!result.ok()) return std::move(result).status();  \
  lhs = std::move(result).value()
