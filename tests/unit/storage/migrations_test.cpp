#include "storage/sqlite/migrations.h"

#include <thread>

#include "storage/sqlite/query.h"
#include "storage_test_support.h"

namespace semmap::storage::sqlite {
namespace {

constexpr Migration kSteps[] = {
    {1, "0001_first", "CREATE TABLE a (x INTEGER) STRICT; INSERT INTO a VALUES (1);"},
    {2, "0002_second", "ALTER TABLE a ADD COLUMN y INTEGER; UPDATE a SET y = x + 1;"},
    {3, "0003_third", "INSERT INTO a VALUES (10, 20);"},
};
constexpr Migration kBroken[] = {
    kSteps[0], kSteps[1], {3, "0003_broken", "INSERT INTO a VALUES (5, 5); NONSENSE;"}};
constexpr char kVersion[] = "PRAGMA user_version";
constexpr char kApplication[] = "PRAGMA application_id";
constexpr char kSum[] = "SELECT sum(y) FROM a";
constexpr char kCountRows[] = "SELECT count(*) FROM a";
constexpr char kJournal[] = "PRAGMA journal_mode";

class Migrations : public testing::Test {
 protected:
  std::unique_ptr<Connection> Open(const std::string& name = "m.db") {
    ConnectionOptions options;
    options.path = dir_.File(name);
    return *Connection::Open(options);
  }

  TempDir dir_;
};

TEST_F(Migrations, RunInOrderOnceAndMarkTheFile) {
  ASSERT_TRUE(MigrateDatabase(*Open(), std::span(kSteps).first(1)).ok());
  const std::unique_ptr<Connection> connection = Open();
  EXPECT_EQ(*QueryInteger(*connection, kVersion), 1);
  EXPECT_EQ(*QueryInteger(*connection, kApplication), kApplicationId);
  ASSERT_TRUE(MigrateDatabase(*connection, kSteps).ok());
  ASSERT_TRUE(MigrateDatabase(*connection, kSteps).ok());
  EXPECT_EQ(*QueryInteger(*connection, kVersion), 3);
  EXPECT_EQ(*QueryInteger(*connection, kSum), 22);
  EXPECT_EQ(*QueryInteger(*connection, kCountRows), 2);
  Query journal(*connection, kJournal);
  ASSERT_TRUE(*journal.Step());
  EXPECT_EQ(journal.Text(0), "wal");
}

TEST_F(Migrations, FailureLeavesTheOldVersion) {
  const std::unique_ptr<Connection> connection = Open();
  ASSERT_TRUE(MigrateDatabase(*connection, std::span(kSteps).first(1)).ok());
  EXPECT_FALSE(MigrateDatabase(*connection, kBroken).ok());
  EXPECT_EQ(*QueryInteger(*connection, kVersion), 1);
  EXPECT_EQ(*QueryInteger(*connection, kCountRows), 1);
  EXPECT_TRUE(MigrateDatabase(*connection, kSteps).ok());
}

TEST_F(Migrations, NewerAndForeignDatabasesAreLeftAlone) {
  ASSERT_TRUE(MigrateDatabase(*Open(), kSteps).ok());
  const absl::Status newer = MigrateDatabase(*Open(), std::span(kSteps).first(2));
  EXPECT_TRUE(absl::IsFailedPrecondition(newer));
  EXPECT_THAT(std::string(newer.message()), testing::HasSubstr("newer"));
  const std::unique_ptr<Connection> foreign = Open("foreign.db");
  ASSERT_TRUE(foreign->Execute("CREATE TABLE songs (title TEXT)").ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(MigrateDatabase(*foreign, kSteps)));
  ASSERT_TRUE(foreign->Execute("PRAGMA application_id=77").ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(MigrateDatabase(*foreign, kSteps)));
  EXPECT_EQ(*QueryInteger(*foreign, kApplication), 77);
  Query journal(*foreign, kJournal);
  ASSERT_TRUE(*journal.Step());
  EXPECT_EQ(journal.Text(0), "delete");
}

TEST_F(Migrations, ManyAtOnceRunThemOnce) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 6; ++i) {
    threads.emplace_back([this] {
      const absl::Status status = MigrateDatabase(*Open(), kSteps);
      EXPECT_TRUE(status.ok()) << status;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(*QueryInteger(*Open(), kCountRows), 2);
}

TEST_F(Migrations, EmbeddedOnesAreNumberedAndMakeStrictTables) {
  const std::span<const Migration> migrations = EmbeddedMigrations();
  ASSERT_FALSE(migrations.empty());
  for (size_t i = 0; i < migrations.size(); ++i) EXPECT_EQ(migrations[i].version, static_cast<int>(i) + 1);
  const std::unique_ptr<Connection> connection = Open();
  ASSERT_TRUE(MigrateDatabase(*connection, migrations).ok());
  constexpr char kLoose[] =
      "SELECT count(*) FROM pragma_table_list WHERE schema = 'main' AND type = 'table' AND strict = 0 "
      "AND name NOT LIKE 'sqlite_%'";
  EXPECT_EQ(*QueryInteger(*connection, kLoose), 0);
}

}  // namespace
}  // namespace semmap::storage::sqlite
