#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/common/ids.h"
#include "storage/byte_buffer.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// One use of a prepared statement: parameters are bound in their order, then rows are stepped through. The
// statement is prepared at its first use on the connection and given back, reset, at the end of this object's
// life.
//
//   Query query(connection, kSelectName);
//   query.Bind(map);
//   SEMMAP_ASSIGN_OR_RETURN(const bool found, query.Step());
//
// The first failure (preparing, binding, stepping) is what Step and Run answer from then on.
class Query {
 public:
  // `sql` is a constant of static storage duration, see Connection::Prepare.
  Query(Connection& connection, const char* sql);
  ~Query();
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  template <std::integral Integer>
  Query& Bind(Integer value) {
    return BindInteger(static_cast<int64_t>(value));
  }
  Query& Bind(double value);
  template <typename Tag>
  Query& Bind(StrongId<Tag> id) {
    return BindInteger(static_cast<int64_t>(id.value()));
  }
  // The bytes must stay as they are until the next Reset or the end.
  Query& BindText(std::string_view text);
  Query& BindBlob(BlobView bytes);
  Query& BindNull();
  template <typename T>
  Query& BindOptional(const std::optional<T>& value) {
    return value.has_value() ? Bind(*value) : BindNull();
  }

  // True: there is a row, its columns can be read until the next Step.
  absl::StatusOr<bool> Step();
  // Steps to the end.
  absl::Status Run();
  // Ready to be bound and run again.
  void Reset();

  // Columns of the row, from 0.
  int64_t Int(int column) const;
  uint64_t Unsigned(int column) const { return static_cast<uint64_t>(Int(column)); }
  double Real(int column) const;
  std::string Text(int column) const;
  BlobView Bytes(int column) const;
  bool IsNull(int column) const;
  template <typename Id>
  Id IdAt(int column) const {
    return Id(Unsigned(column));
  }

 private:
  Query& BindInteger(int64_t value);
  void Note(int code);

  Connection& connection_;
  const char* sql_;
  sqlite3_stmt* statement_ = nullptr;
  bool* in_use_ = nullptr;
  int next_parameter_ = 1;
  absl::Status status_;
};

// Runs `sql` with integer parameters (ids and numbers) to its end.
template <typename... Parameters>
absl::Status RunQuery(Connection& connection, const char* sql, const Parameters&... parameters) {
  Query query(connection, sql);
  (query.Bind(parameters), ...);
  return query.Run();
}

// The first column of the first row as an integer; 0 when there is no row or it is NULL.
template <typename... Parameters>
absl::StatusOr<int64_t> QueryInteger(Connection& connection, const char* sql,
                                     const Parameters&... parameters) {
  Query query(connection, sql);
  (query.Bind(parameters), ...);
  const absl::StatusOr<bool> row = query.Step();
  if (!row.ok()) return row.status();
  return *row ? query.Int(0) : 0;
}

}  // namespace semmap::storage::sqlite
