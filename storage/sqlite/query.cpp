#include "storage/sqlite/query.h"

#include <sqlite3.h>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/sqlite/sqlite_status.h"

namespace semmap::storage::sqlite {

Query::Query(Connection& connection, const char* sql) : connection_(connection), sql_(sql) {
  const absl::StatusOr<Connection::Prepared*> prepared = connection.Prepare(sql);
  if (!prepared.ok()) {
    status_ = prepared.status();
    return;
  }
  if ((*prepared)->in_use) {
    status_ = absl::InternalError(absl::StrCat("statement used within itself: ", sql));
    return;
  }
  statement_ = (*prepared)->statement;
  in_use_ = &(*prepared)->in_use;
  *in_use_ = true;
}

Query::~Query() {
  if (statement_ == nullptr) return;
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
  *in_use_ = false;
}

void Query::Note(int code) {
  if (code != SQLITE_OK && status_.ok()) status_ = SqliteStatus(connection_.handle(), code, sql_);
}

Query& Query::BindInteger(int64_t value) {
  if (statement_ != nullptr) Note(sqlite3_bind_int64(statement_, next_parameter_++, value));
  return *this;
}

Query& Query::Bind(double value) {
  if (statement_ != nullptr) Note(sqlite3_bind_double(statement_, next_parameter_++, value));
  return *this;
}

Query& Query::BindText(std::string_view text) {
  if (statement_ == nullptr) return *this;
  // A null pointer would be NULL.
  const char* data = text.data() == nullptr ? "" : text.data();
  Note(sqlite3_bind_text64(statement_, next_parameter_++, data, text.size(), SQLITE_STATIC, SQLITE_UTF8));
  return *this;
}

Query& Query::BindBlob(BlobView bytes) {
  if (statement_ == nullptr) return *this;
  const void* data = bytes.empty() ? static_cast<const void*>("") : bytes.data();
  Note(sqlite3_bind_blob64(statement_, next_parameter_++, data, bytes.size(), SQLITE_STATIC));
  return *this;
}

Query& Query::BindNull() {
  if (statement_ != nullptr) Note(sqlite3_bind_null(statement_, next_parameter_++));
  return *this;
}

absl::StatusOr<bool> Query::Step() {
  if (!status_.ok()) return status_;
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  Note(code);
  return status_;
}

absl::Status Query::Run() {
  while (true) {
    SEMMAP_ASSIGN_OR_RETURN(const bool row, Step());
    if (!row) return absl::OkStatus();
  }
}

void Query::Reset() {
  if (statement_ != nullptr) sqlite3_reset(statement_);
  next_parameter_ = 1;
}

int64_t Query::Int(int column) const { return sqlite3_column_int64(statement_, column); }

double Query::Real(int column) const { return sqlite3_column_double(statement_, column); }

std::string Query::Text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  return text == nullptr ? std::string()
                         : std::string(text, static_cast<size_t>(sqlite3_column_bytes(statement_, column)));
}

BlobView Query::Bytes(int column) const {
  const auto* bytes = static_cast<const uint8_t*>(sqlite3_column_blob(statement_, column));
  return bytes == nullptr ? BlobView()
                          : BlobView(bytes, static_cast<size_t>(sqlite3_column_bytes(statement_, column)));
}

bool Query::IsNull(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }

}  // namespace semmap::storage::sqlite
