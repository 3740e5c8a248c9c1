// The documentation against the code: generated tables, and names of files, functions and tests.
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/experiment/keys.hpp"
#include "core/host/exit_codes.hpp"
#include "core/plugins/describe.hpp"
#include "core/plugins/registry.hpp"

namespace somas {
namespace {

namespace fs = std::filesystem;

const fs::path root = SOMAS_SOURCE_DIR;

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file << " cannot be read";
  return {std::istreambuf_iterator<char>(in), {}};
}

// Relative to the root.
std::vector<fs::path> pages() {
  std::vector<fs::path> found = {"README.md"};
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") found.push_back(fs::relative(entry.path(), root));
  return found;
}

// All matches of the pattern: of each the whole, then its groups.
std::vector<std::vector<std::string>> matches(const std::string& text, const std::regex& pattern) {
  std::vector<std::vector<std::string>> found;
  for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it)
    found.emplace_back(it->begin(), it->end());
  return found;
}

// The text without its fenced blocks.
std::string prose_of(const std::string& text) {
  std::istringstream in(text);
  std::string prose;
  bool fenced = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("```"))
      fenced = !fenced;
    else if (!fenced)
      prose += line + "\n";
  }
  return prose;
}

// ---- generated parts ---------------------------------------------------------------------------

const plugins::Registry& bundled() {
  static const plugins::Registry registry({{fs::path(SOMAS_BINARY_DIR) / "plugins", "build tree"}});
  return registry;
}

// Every bundled plugin, with a link to its reference.
std::string plugin_table() {
  std::string table = "| plugin | kind | what it is |\n|---|---|---|\n";
  for (const PluginKind kind : {PluginKind::environment, PluginKind::specialization,
                                PluginKind::controller, PluginKind::fitness})
    for (const std::string& id : bundled().ids(kind))
      table += "| [`" + id + "`](reference/plugins/" + id + ".md) | " + plugins::kind_name(kind) +
               " | " + bundled().find(id).info->doc + " |\n";
  return table;
}

std::string generated(const std::string& name) {
  if (name == "keys") return experiment::keys_reference();
  if (name == "exit codes") return std::string("```text\n") + host::exit_code_help + "```\n";
  if (name == "plugins") return plugin_table();
  ADD_FAILURE() << "nothing is called '" << name << "'";
  return {};
}

// A part of a page between two comments, the first at the beginning of a line.
struct Part {
  std::string name;
  std::size_t begin, end;  // of what is between
};

std::vector<Part> generated_parts(const std::string& text) {
  const std::string opening = "\n<!-- generated: ", closing = " -->\n", last = "<!-- end -->";
  std::vector<Part> parts;
  for (std::size_t at = text.find(opening); at != std::string::npos; at = text.find(opening, at)) {
    const std::size_t name = at + opening.size(), name_end = text.find(closing, name);
    const std::size_t end = text.find(last, name);
    if (name_end == std::string::npos || end == std::string::npos) {
      ADD_FAILURE() << "a generated part has no end";
      break;
    }
    parts.push_back({text.substr(name, name_end - name), name_end + closing.size(), end});
    at = end;
  }
  return parts;
}

TEST(Generated, PartsAreUpToDate) {
  for (const fs::path& page : pages()) {
    const std::string text = read(root / page);
    std::string fresh;
    std::size_t done = 0;
    for (const Part& part : generated_parts(text)) {
      fresh += text.substr(done, part.begin - done) + generated(part.name);
      done = part.end;
    }
    fresh += text.substr(done);
    if (fresh == text) continue;
    if (std::getenv("SOMAS_UPDATE_DOCS") != nullptr)
      std::ofstream(root / page, std::ios::binary) << fresh;
    else
      ADD_FAILURE() << page << " is out of date; run: SOMAS_UPDATE_DOCS=1 ./dev test -R Generated";
  }
}

TEST(Generated, PartsOfTheGuideAreThere) {
  std::set<std::string> found;
  for (const Part& part : generated_parts(read(root / "docs/guide.md"))) found.insert(part.name);
  EXPECT_EQ(found, (std::set<std::string>{"exit codes", "keys", "plugins"}));
}

// One for each bundled plugin, and no other.
TEST(Generated, ReferencesOfPluginsAreUpToDate) {
  const fs::path directory = root / "docs/reference/plugins";
  std::set<std::string> expected, found;
  ASSERT_FALSE(bundled().ids().empty());
  for (const std::string& id : bundled().ids()) {
    expected.insert(id + ".md");
    const std::string page =
        plugins::describe(bundled().find(id), plugins::DescribeFormat::markdown);
    if (std::getenv("SOMAS_UPDATE_DOCS") != nullptr)
      std::ofstream(directory / (id + ".md"), std::ios::binary) << page;
    EXPECT_EQ(read(directory / (id + ".md")), page)
        << "run: SOMAS_UPDATE_DOCS=1 ./dev test -R Generated";
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(directory))
    found.insert(entry.path().filename().string());
  EXPECT_EQ(found, expected);
}

// ---- names -------------------------------------------------------------------------------------

// "Suite.Test" of every test in the tree.
std::set<std::string> all_tests() {
  const std::regex test(
      R"((?:TEST|TEST_F|TEST_P|RC_GTEST_PROP|RC_GTEST_FIXTURE_PROP)\(\s*(\w+),\s*(\w+))");
  std::set<std::string> names;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / "tests"))
    if (entry.path().filename().string().ends_with("_test.cpp"))
      for (const auto& match : matches(read(entry.path()), test))
        names.insert(match[1] + "." + match[2]);
  return names;
}

bool has_word(const std::string& text, const std::string& word) {
  return std::regex_search(text, std::regex("\\b" + word + "\\b"));
}

std::vector<std::string> code_spans(const fs::path& page) {
  std::vector<std::string> spans;
  for (const auto& span : matches(prose_of(read(root / page)), std::regex("`([^`\n]+)`")))
    spans.push_back(span[1]);
  return spans;
}

TEST(Names, OfFilesExist) {
  const std::regex path(
      R"(((?:core|plugins|sdk|bench|tests|cmake|experiments|docs|\.ci)/[\w./-]*)(: .*)?)");
  for (const fs::path& page : pages())
    for (const std::string& span : code_spans(page)) {
      std::smatch match;
      if (!std::regex_match(span, match, path)) continue;
      EXPECT_TRUE(fs::exists(root / match[1].str())) << page << " names " << span;
    }
}

TEST(Names, OfFunctionsStandInTheirFiles) {
  const std::regex function(R"(((?:core|plugins|sdk)/[\w./-]+\.[ch]pp): ([\w:]+))");
  std::size_t count = 0;
  for (const fs::path& page : pages())
    for (const std::string& span : code_spans(page)) {
      std::smatch match;
      if (!std::regex_match(span, match, function)) continue;
      ++count;
      const std::string text = read(root / match[1].str());
      for (const auto& word : matches(match[2].str(), std::regex("\\w+")))
        EXPECT_TRUE(has_word(text, word[0])) << page << " names " << span;
    }
  EXPECT_GT(count, 30u);
}

TEST(Names, OfTestsExist) {
  const std::set<std::string> tests = all_tests();
  const std::regex test(R"([A-Z]\w*\.[A-Z]\w+)");
  std::size_t count = 0;
  for (const fs::path& page : pages())
    for (const std::string& span : code_spans(page)) {
      if (!std::regex_match(span, test)) continue;
      ++count;
      EXPECT_TRUE(tests.contains(span)) << page << " names the test " << span;
    }
  EXPECT_GT(count, 60u);
}

// As GitHub makes it from a heading.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || c == '-' || c == '_')
      anchor += static_cast<char>(std::tolower(byte));
    if (c == ' ') anchor += '-';
  }
  return anchor;
}

TEST(Names, OfLinksLeadSomewhere) {
  const std::regex link(R"(\]\(([^)#:]*)(#([^)]*))?\))");
  for (const fs::path& page : pages())
    for (const auto& match : matches(prose_of(read(root / page)), link)) {
      const fs::path target = match[1].empty() ? root / page : root / page.parent_path() / match[1];
      ASSERT_TRUE(fs::exists(target)) << page << " links to " << match[0];
      if (match[3].empty()) continue;
      std::set<std::string> anchors;
      for (const auto& heading : matches(prose_of(read(target)), std::regex("(^|\n)#+ ([^\n]*)")))
        anchors.insert(anchor_of(heading[2]));
      EXPECT_TRUE(anchors.contains(match[3])) << page << " links to " << match[0];
    }
}

// Comments in the code refer to sections of the model by number.
TEST(Names, OfSectionsKeepTheirNumbers) {
  const std::string model = read(root / "docs/model.md");
  for (const char* section : {"0 One step", "1 Morphogens", "2 Nutrients", "3 Mechanics",
                              "4 Cell cycle", "5 Specialization tree", "6 Gene regulatory network",
                              "7 Genetic algorithm", "8 Experiments"})
    EXPECT_THAT(model, testing::HasSubstr("\n## " + std::string(section)));
}

// ---- the plugin of the SDK's first page --------------------------------------------------------

TEST(Example, OfTheGuideIsThatOfTheHeader) {
  // The header has it as a comment, indented by "///   ".
  std::istringstream header(read(root / "sdk/include/somas/sdk/plugin.hpp"));
  std::string example;
  for (std::string line; std::getline(header, line) && line.starts_with("///");)
    if (line.starts_with("///   ")) example += line.substr(6) + "\n";
  const std::string guide = read(root / "docs/plugins.md");
  const std::string mark = "<!-- file: breeze/breeze.cpp -->\n```cpp\n";
  const std::size_t begin = guide.find(mark);
  ASSERT_NE(begin, std::string::npos);
  const std::size_t end = guide.find("```\n", begin + mark.size());
  EXPECT_EQ(guide.substr(begin + mark.size(), end - begin - mark.size()), example);
}

}  // namespace
}  // namespace somas
