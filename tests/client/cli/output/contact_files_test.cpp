#include "client/cli/output/contact_files.hpp"

#include <gtest/gtest.h>

#include "client/cli/output/numbered.hpp"

namespace collided::cli {
namespace {

TEST(Numbered, HasFourDigitsOrMore) {
  EXPECT_EQ(numbered("a_{frame}.vtp", 7), "a_0007.vtp");
  EXPECT_EQ(numbered("{frame}/{frame}", 12345), "12345/12345");
  EXPECT_EQ(numbered("a.vtp", 7), "a.vtp");
}

TEST(SeriesName, IsThatOfTheFilesWithoutTheirNumber) {
  EXPECT_EQ(series_name("contacts_{frame}.vtp"), "contacts.pvd");
  EXPECT_EQ(series_name("out/knot-{frame}-contacts.vtp"), "out/knot-contacts.pvd");
  EXPECT_EQ(series_name("/tmp/{frame}.vtp"), "/tmp/contacts.pvd");
  EXPECT_EQ(series_name("c.{frame}.vtp"), "c.pvd");
}

}  // namespace
}  // namespace collided::cli
