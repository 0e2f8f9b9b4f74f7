#include "handler_fixture.h"
#include "server/handlers/map_handlers.h"

namespace semmap::server {
namespace {

using ListMapsTest = HandlerTest;

TEST_F(ListMapsTest, GivesEveryMapOnceInPages) {
  for (const char* name : {"c", "a", "e", "b", "d"}) MakeMap(name, std::string("s-") + name, 1);
  std::vector<std::string> names;
  v1::ListMapsRequest request;
  request.set_page_size(2);
  int pages = 0;
  do {
    const auto response = ListMaps(context_, request);
    ASSERT_TRUE(response.ok()) << response.status();
    for (const v1::Map& map : response->maps()) names.push_back(map.name());
    request.set_page_token(response->next_page_token());
    ++pages;
  } while (!request.page_token().empty());
  EXPECT_EQ(names, (std::vector<std::string>{"maps/a", "maps/b", "maps/c", "maps/d", "maps/e"}));
  EXPECT_EQ(pages, 3);
}

TEST_F(ListMapsTest, RefusesBadPages) {
  v1::ListMapsRequest request;
  request.set_page_size(-1);
  EXPECT_EQ(ReasonOf(ListMaps(context_, request).status()), v1::ERROR_REASON_FIELD_INVALID);
  request.set_page_size(0);
  request.set_page_token("made up");
  EXPECT_EQ(ReasonOf(ListMaps(context_, request).status()), v1::ERROR_REASON_PAGE_TOKEN_INVALID);
}

}  // namespace
}  // namespace semmap::server
