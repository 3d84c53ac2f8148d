#include "client/app/output/contact_files.hpp"

#include <gtest/gtest.h>

#include "client/app/output/numbered.hpp"

namespace collided::cli {
namespace {

TEST(Numbered, HasFourDigitsOrMore) {
  EXPECT_EQ(numbered("a_{frame}.vtp", 7), "a_0007.vtp");
  EXPECT_EQ(numbered("{frame}/{frame}", 12345), "12345/12345");
  EXPECT_EQ(numbered("a.vtp", 7), "a.vtp");
}

TEST(Numbered, KnowsTheNamesThatItGives) {
  for (const char* name : {"a_0001.ply", "a_0012.ply", "a_12345.ply"})
    EXPECT_TRUE(gives("a_{frame}.ply", name)) << name;
  for (const char* name : {"a_001.ply", "a_00001.ply", "a_0001.vtp", "b_0001.ply", "a_.ply", "a_", "", "a_-001.ply"})
    EXPECT_FALSE(gives("a_{frame}.ply", name)) << name;
  EXPECT_TRUE(gives("{frame}/{frame}0", "0007/00070"));
  EXPECT_FALSE(gives("{frame}/{frame}0", "0007/00080"));
  EXPECT_FALSE(gives("a.ply", "a.ply"));
}

TEST(SeriesName, IsThatOfTheFilesWithoutTheirNumber) {
  EXPECT_EQ(series_name("contacts_{frame}.vtp"), "contacts.pvd");
  EXPECT_EQ(series_name("out/knot-{frame}-contacts.vtp"), "out/knot-contacts.pvd");
  EXPECT_EQ(series_name("/tmp/{frame}.vtp"), "/tmp/contacts.pvd");
  EXPECT_EQ(series_name("c.{frame}.vtp"), "c.pvd");
}

}  // namespace
}  // namespace collided::cli
