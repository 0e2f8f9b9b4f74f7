#include "slam/common/status_macros.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/reader_pool.h"
#include "storage/sqlite/transaction.h"
#include "storage_test_support.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kCount[] = "SELECT count(*) FROM t";
constexpr char kInsert[] = "INSERT INTO t VALUES (?, ?, ?, ?)";
constexpr char kSelect[] = "SELECT * FROM t";
constexpr char kNonsense[] = "SELECT nothing FROM nowhere";

class SqliteConnection : public testing::Test {
 protected:
  SqliteConnection() {
    options_.path = dir_.File("t.db");
    options_.busy_timeout_ms = 0;
    connection_ = Open();
    EXPECT_TRUE(
        connection_->Execute("PRAGMA journal_mode=WAL; CREATE TABLE t (i INTEGER, r REAL, t TEXT, b BLOB)")
            .ok());
  }

  std::unique_ptr<Connection> Open() {
    absl::StatusOr<std::unique_ptr<Connection>> connection = Connection::Open(options_);
    EXPECT_TRUE(connection.ok()) << connection.status();
    return *std::move(connection);
  }

  absl::Status InsertOne(Connection& connection) {
    return Query(connection, kInsert).Bind(1).BindNull().BindNull().BindNull().Run();
  }

  TempDir dir_;
  ConnectionOptions options_;
  std::unique_ptr<Connection> connection_;
};

TEST_F(SqliteConnection, ValuesGoInAndOut) {
  const std::string text("a\0b", 3);
  const Blob bytes = {0, 255, 0};
  ASSERT_TRUE(Query(*connection_, kInsert)
                  .Bind(uint64_t{1} << 62)
                  .Bind(-0.5)
                  .BindText(text)
                  .BindBlob(bytes)
                  .Run()
                  .ok());
  ASSERT_TRUE(Query(*connection_, kInsert)
                  .BindOptional(std::optional<int64_t>())
                  .BindNull()
                  .BindText({})
                  .BindBlob({})
                  .Run()
                  .ok());
  Query select(*connection_, kSelect);
  ASSERT_TRUE(*select.Step());
  EXPECT_EQ(select.Unsigned(0), uint64_t{1} << 62);
  EXPECT_EQ(select.Real(1), -0.5);
  EXPECT_EQ(select.Text(2), text);
  EXPECT_EQ(Blob(select.Bytes(3).begin(), select.Bytes(3).end()), bytes);
  ASSERT_TRUE(*select.Step());
  EXPECT_TRUE(select.IsNull(0));
  EXPECT_FALSE(select.IsNull(2));  // empty is not NULL
  EXPECT_FALSE(select.IsNull(3));
  EXPECT_FALSE(*select.Step());
}

TEST_F(SqliteConnection, QueriesReportTheirFirstFailure) {
  Query nonsense(*connection_, kNonsense);
  EXPECT_EQ(nonsense.Bind(1).Run().code(), absl::StatusCode::kInternal);
  Query too_many(*connection_, kCount);
  EXPECT_TRUE(absl::IsInvalidArgument(too_many.Bind(1).Run()));
  Query outer(*connection_, kSelect);
  Query inner(*connection_, kSelect);  // the one statement is in use
  EXPECT_EQ(inner.Step().status().code(), absl::StatusCode::kInternal);
  EXPECT_TRUE(outer.Step().ok());
}

TEST_F(SqliteConnection, TransactionsRollBackUnlessCommitted) {
  {
    absl::StatusOr<Transaction> transaction = Transaction::Begin(*connection_, Transaction::Kind::kWrite);
    ASSERT_TRUE(transaction.ok());
    ASSERT_TRUE(InsertOne(*connection_).ok());
    EXPECT_EQ(*QueryInteger(*connection_, kCount), 1);
  }
  EXPECT_EQ(*QueryInteger(*connection_, kCount), 0);
  {
    absl::StatusOr<Transaction> transaction = Transaction::Begin(*connection_, Transaction::Kind::kWrite);
    ASSERT_TRUE(InsertOne(*connection_).ok());
    Transaction moved = *std::move(transaction);
    ASSERT_TRUE(moved.Commit().ok());
  }
  EXPECT_EQ(*QueryInteger(*connection_, kCount), 1);
}

TEST_F(SqliteConnection, UnwindingRollsBack) {
  const auto fails_half_way = [&]() -> absl::Status {
    SEMMAP_ASSIGN_OR_RETURN(const Transaction transaction,
                            Transaction::Begin(*connection_, Transaction::Kind::kWrite));
    SEMMAP_RETURN_IF_ERROR(InsertOne(*connection_));
    return absl::DataLossError("half way");
  };
  EXPECT_TRUE(absl::IsDataLoss(fails_half_way()));
  EXPECT_EQ(*QueryInteger(*connection_, kCount), 0);
}

TEST_F(SqliteConnection, SecondWriterIsTurnedAwayReaderIsNot) {
  const std::unique_ptr<Connection> other = Open();
  absl::StatusOr<Transaction> transaction = Transaction::Begin(*connection_, Transaction::Kind::kWrite);
  ASSERT_TRUE(InsertOne(*connection_).ok());
  EXPECT_TRUE(absl::IsUnavailable(Transaction::Begin(*other, Transaction::Kind::kWrite).status()));
  EXPECT_EQ(*QueryInteger(*other, kCount), 0);
}

TEST_F(SqliteConnection, PoolLendsSnapshotsUpToItsLimit) {
  options_.busy_timeout_ms = 20;
  ReaderPool pool(options_, 2);
  {
    absl::StatusOr<ReaderPool::Lease> first = pool.Read();
    ASSERT_TRUE(first.ok()) << first.status();
    EXPECT_EQ(*QueryInteger(first->connection(), kCount), 0);
    ASSERT_TRUE(InsertOne(*connection_).ok());
    absl::StatusOr<ReaderPool::Lease> second = pool.Read();
    ASSERT_TRUE(second.ok());
    EXPECT_EQ(*QueryInteger(first->connection(), kCount), 0);
    EXPECT_EQ(*QueryInteger(second->connection(), kCount), 1);
    EXPECT_TRUE(absl::IsUnavailable(pool.Read().status()));
    // Readers read.
    EXPECT_TRUE(absl::IsPermissionDenied(InsertOne(first->connection())));
  }
  absl::StatusOr<ReaderPool::Lease> again = pool.Read();
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(*QueryInteger(again->connection(), kCount), 1);
}

TEST_F(SqliteConnection, PoolSurvivesFailedOpens) {
  options_.path = dir_.File("nowhere/t.db");
  ReaderPool pool(options_, 1);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(absl::IsPermissionDenied(pool.Read().status()));
}

}  // namespace
}  // namespace semmap::storage::sqlite
