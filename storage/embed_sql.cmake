# cmake -DOUTPUT=file.cpp -DMIGRATIONS="0001_a.sql;0002_b.sql" -P embed_sql.cmake
# Turns the numbered migrations into a C++ table, so that a program carries its own schema.
set(entries "")
set(expected 1)
foreach(path ${MIGRATIONS})
  get_filename_component(name ${path} NAME_WE)
  if(NOT name MATCHES "^([0-9][0-9][0-9][0-9])_[a-z0-9_]+$")
    message(FATAL_ERROR "${path}: a migration is named 0001_what_it_does.sql")
  endif()
  math(EXPR version "1${CMAKE_MATCH_1} - 10000")
  if(NOT version EQUAL expected)
    message(FATAL_ERROR "${path}: migration ${expected} is missing")
  endif()
  math(EXPR expected "${expected} + 1")
  file(READ ${path} sql)
  string(APPEND entries "    {${version}, \"${name}\", R\"sql(${sql})sql\"},\n")
endforeach()
file(WRITE ${OUTPUT}.tmp "// Made from storage/migrations by storage/embed_sql.cmake.
#include \"storage/sqlite/migrations.h\"

namespace semmap::storage::sqlite {
namespace {

constexpr Migration kMigrations[] = {
${entries}};

}  // namespace

std::span<const Migration> EmbeddedMigrations() { return kMigrations; }

}  // namespace semmap::storage::sqlite
")
file(RENAME ${OUTPUT}.tmp ${OUTPUT})
