// A ready file is replaced as a whole, and never something else.
#include "server/ops/supervisor/ready_file.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace collided::server {
namespace {

namespace fs = std::filesystem;

class ReadyFile : public ::testing::Test {
 protected:
  ReadyFile() {
    std::string name = (fs::temp_directory_path() / "collided-ready-XXXXXX").string();
    folder = mkdtemp(name.data());
  }
  ~ReadyFile() override { fs::remove_all(folder); }

  std::string at(const std::string& name) const { return (folder / name).string(); }
  static std::string text_of(const std::string& path) {
    std::stringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }

  fs::path folder;
};

TEST_F(ReadyFile, HasAnAddressALineAndReplacesAnOldOne) {
  for (const std::vector<std::string>& addresses : {std::vector<std::string>{"a", "b"}, {"c"}}) {
    EXPECT_EQ(ready_file_obstacle(at("ready")), "");
    write_ready_file(at("ready"), addresses);
  }
  EXPECT_EQ(text_of(at("ready")), "c\n");
  EXPECT_FALSE(fs::exists(at("ready.part")));
  EXPECT_EQ(ready_file_obstacle(""), "");
  EXPECT_EQ(ready_file_obstacle("ready"), "");
}

TEST_F(ReadyFile, WhatIsNoRegularFileIsLeftAlone) {
  ASSERT_EQ(mkfifo(at("pipe").c_str(), 0600), 0);
  std::ofstream(at("target")) << "old";
  fs::create_symlink(at("target"), at("link"));
  fs::create_symlink(at("nothing"), at("dangling"));
  for (const auto& path : {at("pipe"), at("link"), at("dangling"), folder.string(), std::string("/dev/null")})
    EXPECT_EQ(ready_file_obstacle(path), "what is there is not a regular file") << path;
}

TEST_F(ReadyFile, ItsFolderMustBeThere) {
  EXPECT_EQ(ready_file_obstacle(at("no/ready")), "there is no folder " + at("no"));
  EXPECT_THROW(write_ready_file(at("no/ready"), {"a"}), std::runtime_error);
}

}  // namespace
}  // namespace collided::server
