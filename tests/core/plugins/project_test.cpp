#include "core/plugins/project.hpp"

#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/run/scratch.hpp"

namespace somas::plugins {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

const fs::path templates = SOMAS_SOURCE_DIR "/sdk/template";

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <class Call>
std::string complaint(Call&& call) {
  try {
    call();
    return "";
  } catch (const ProjectError& error) {
    return error.what();
  }
}

class Project : public testing::Test {
 protected:
  fs::path path(const std::string& name) const { return scratch_.path() / name; }
  std::string complaint_of(const std::string& name, const fs::path& directory) const {
    return complaint([&] { write_project(PluginKind::fitness, name, directory, templates); });
  }
  std::size_t entries() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(scratch_.path()), fs::directory_iterator()));
  }
  test::Scratch scratch_;
};

TEST_F(Project, HasFilesOfItsName) {
  const auto files =
      write_project(PluginKind::environment, "salt_marsh", path("deep/marsh"), templates);
  for (const char* file : {"CMakeLists.txt", "README.md", ".gitignore", "plugin.cpp",
                           "salt_marsh.hpp", "salt_marsh_test.cpp", "salt_marsh.yaml"}) {
    EXPECT_THAT(files, Contains(fs::path(file)));
    EXPECT_TRUE(fs::exists(path("deep/marsh") / file)) << file;
  }
  EXPECT_THAT(read(path("deep/marsh/salt_marsh.hpp")), HasSubstr("class SaltMarsh final"));
}

TEST_F(Project, KeepsNoWordOfTheTemplate) {
  for (const PluginKind kind : {PluginKind::environment, PluginKind::specialization,
                                PluginKind::controller, PluginKind::fitness}) {
    const fs::path directory = path(std::to_string(static_cast<int>(kind)));
    for (const fs::path& file : write_project(kind, "marsh", directory, templates)) {
      const std::string text = read(directory / file);
      EXPECT_FALSE(text.empty()) << file;
      for (const char* word : {"my_plugin", "MyPlugin", "@"})
        EXPECT_THAT(text, Not(HasSubstr(word))) << file;
    }
  }
}

TEST_F(Project, ListsTheSourcesOfAController) {
  write_project(PluginKind::controller, "marsh", path("a"), templates);
  EXPECT_THAT(read(path("a/CMakeLists.txt")),
              HasSubstr("somas_add_plugin(marsh SOURCES plugin.cpp genes.cpp program.cpp)"));
}

TEST_F(Project, TakesAnEmptyDirectory) {
  fs::create_directory(path("empty"));
  EXPECT_EQ(complaint_of("marsh", path("empty/")), "");
  EXPECT_TRUE(fs::exists(path("empty/marsh.hpp")));
}

TEST_F(Project, NeverTouchesWhatIsThere) {
  fs::create_directory(path("full"));
  std::ofstream(path("full/notes")) << "mine";
  EXPECT_EQ(complaint_of("marsh", path("full")),
            path("full").string() + " exists already and is no empty directory; name another");
  EXPECT_EQ(
      complaint_of("marsh", path("full/notes")),
      path("full/notes").string() + " exists already and is no empty directory; name another");
  EXPECT_EQ(complaint_of("marsh", ""), "the directory's name is empty");
  EXPECT_EQ(read(path("full/notes")), "mine");
  EXPECT_EQ(entries(), 1u) << "nothing is left beside it";
}

TEST_F(Project, SaysThatTheTemplatesAreMissing) {
  const std::string text =
      complaint([&] { write_project(PluginKind::fitness, "marsh", path("a"), path("none")); });
  EXPECT_THAT(text, HasSubstr("the templates are missing: " + path("none/fitness").string()));
  EXPECT_EQ(entries(), 0u);
}

TEST(ProjectName, IsAWord) {
  for (const char* name : {"marsh", "salt_marsh", "a1", "x"})
    EXPECT_EQ(complaint([&] { check_project_name(name); }), "") << name;
  for (const char* name : {"", "Marsh", "salt-marsh", "1a", "_a", "a_", "a__b", "a b", "a/b", "ä"})
    EXPECT_THAT(complaint([&] { check_project_name(name); }),
                HasSubstr("' cannot be the name of a plugin; use lower_snake_case"))
        << name;
  EXPECT_THAT(complaint([&] { check_project_name(std::string(65, 'a')); }),
              HasSubstr("at most 64"));
}

TEST(ProjectName, MeansNothingElse) {
  for (const char* name : {"test", "all", "plugin", "parameters", "marsh_test", "null"})
    EXPECT_THAT(complaint([&] { check_project_name(name); }), HasSubstr("has a meaning of its own"))
        << name;
}

TEST(ProjectName, BecomesAClass) {
  EXPECT_EQ(class_name_of("marsh"), "Marsh");
  EXPECT_EQ(class_name_of("salt_marsh2"), "SaltMarsh2");
  EXPECT_EQ(class_name_of("a_1b"), "A1b");
}

}  // namespace
}  // namespace somas::plugins
