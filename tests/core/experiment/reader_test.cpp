#include "core/experiment/reader.hpp"

#include <gmock/gmock.h>

#include "tests/core/experiment/files.hpp"

namespace somas::experiment {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class Reader : public Files {
 protected:
  static std::string parse_complaint(const std::string& text) {
    try {
      static_cast<void>(parse_yaml(text, "e.yaml"));
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  }
};

TEST_F(Reader, RemembersWhereKeysAndValuesStand) {
  const Node root = parse_yaml("a: 1\nb:\n  c: [x, 'y']\n", "e.yaml");
  const Node& c = nearest(root, "b.c");
  EXPECT_EQ(c.key_position.text(), "e.yaml:3:3");
  EXPECT_EQ(c.position.text(), "e.yaml:3:6");
  EXPECT_EQ(c.items[1].position.text(), "e.yaml:3:10");
  EXPECT_FALSE(c.items[0].quoted);
  EXPECT_TRUE(c.items[1].quoted);
}

TEST_F(Reader, FindsTheNearestEnclosingNode) {
  const Node root = parse_yaml("a:\n  b.c: 1\n  d: [1, {e: 2}]\n", "e.yaml");
  EXPECT_EQ(nearest(root, "a.b.c").text, "1");
  EXPECT_EQ(nearest(root, "a.d[1].e").text, "2");
  EXPECT_EQ(nearest(root, "a.d.1.e").text, "2");
  EXPECT_EQ(nearest(root, "a.d[7].e").key, "d");
  EXPECT_EQ(&nearest(root, "x.y"), &root);
}

TEST_F(Reader, RefusesDuplicateKeysWithBothPlaces) {
  EXPECT_EQ(parse_complaint("w:\n  radius: 1\n  size: 2\n  radius: 3\n"),
            "e.yaml:4:3: w.radius: duplicate key; it was first given at e.yaml:2:3");
  EXPECT_EQ(parse_complaint("l:\n  - {a: 1, a: 2}\n"),
            "e.yaml:2:12: l[0].a: duplicate key; it was first given at e.yaml:2:6");
}

TEST_F(Reader, RefusesAnchorsAliasesTagsAndMergeKeys) {
  EXPECT_THAT(parse_complaint("a: &x 1\n"), StartsWith("e.yaml:1:4: a: anchors (&name) are not"));
  EXPECT_THAT(parse_complaint("a: !!str 1\n"), StartsWith("e.yaml:1:4: a: tags (!name) are not"));
  EXPECT_THAT(parse_complaint("<<: {a: 1}\n"), StartsWith("e.yaml:1:1: merge keys (<<) are not"));
}

TEST_F(Reader, RefusesKeysThatAreNoTexts) {
  EXPECT_EQ(parse_complaint("? [a, b]\n: 1\n"), "e.yaml:1:3: a key must be a text");
  EXPECT_EQ(parse_complaint("? \n: 1\n"), "e.yaml:2:1: a key is missing before ':'");
}

TEST_F(Reader, RefusesASecondDocument) {
  EXPECT_THAT(parse_complaint("a: 1\n---\nb: 2\n"), StartsWith("e.yaml:3:1: a second document"));
}

TEST_F(Reader, RefusesDeepNesting) {
  EXPECT_EQ(parse_complaint(std::string(200000, '[')), "e.yaml:1:33: nested deeper than 64 levels");
  std::string blocks_of_lists;
  for (int i = 0; i < 200000; ++i) blocks_of_lists += "- ";
  EXPECT_EQ(parse_complaint(blocks_of_lists + "x"), "e.yaml:1:129: nested deeper than 64 levels");
  std::string maps;
  for (int i = 0; i < 200000; ++i) maps += "{a: ";
  EXPECT_EQ(parse_complaint(maps), "e.yaml:1:253: nested deeper than 64 levels");
}

TEST_F(Reader, AllowsWhatIsJustNotTooDeep) {
  const std::string open(64, '['), close(64, ']');
  EXPECT_EQ(parse_complaint(open + close), "");
}

TEST_F(Reader, PlacesSyntaxErrors) {
  EXPECT_THAT(parse_complaint("a: 1\n b: 2\n"), StartsWith("e.yaml:2:3: not valid YAML: "));
  EXPECT_THAT(parse_complaint("a: [1, 2\n"), StartsWith("e.yaml:2:1: not valid YAML: "));
  EXPECT_EQ(parse_complaint("a: \"x\nb: 2\n"), "e.yaml:2:5: not valid YAML: a quote is not closed");
}

TEST_F(Reader, SaysThatAFileIsEmpty) {
  EXPECT_EQ(complaint(""), "e.yaml:1:1: the file is empty");
  EXPECT_EQ(complaint("# only a comment\n"), "e.yaml:1:1: the file is empty");
  EXPECT_THAT(complaint("---\n"), HasSubstr(": the file is empty"));
}

TEST_F(Reader, SaysThatAFileIsNone) {
  std::filesystem::create_directory(directory_ / "d.yaml");
  EXPECT_EQ(complaint_of(directory_ / "d.yaml"), "d.yaml: a directory, not an experiment file");
  EXPECT_EQ(complaint_of(directory_ / "none.yaml"), "none.yaml: no such file");
}

TEST_F(Reader, RefusesAFileAboveOneMebibyte) {
  EXPECT_EQ(complaint(std::string(largest_file + 1, '#')),
            "e.yaml: larger than 1 MiB: not an experiment file");
  EXPECT_EQ(complaint(std::string(largest_file, '#')), "e.yaml:1:1: the file is empty");
}

TEST_F(Reader, RefusesWhatIsNoText) {
  EXPECT_EQ(complaint("a: 1\nb: \xFF\n"), "e.yaml:2:4: not UTF-8 text; save the file as UTF-8");
  EXPECT_EQ(complaint("a: \xC0\xAF\n"), "e.yaml:1:4: not UTF-8 text; save the file as UTF-8");
  EXPECT_EQ(complaint("a: \xED\xA0\x80\n"), "e.yaml:1:4: not UTF-8 text; save the file as UTF-8");
  EXPECT_EQ(complaint(std::string("a: \0b\n", 6)),
            "e.yaml:1:4: a control character: not a text file, or a damaged one");
  EXPECT_EQ(complaint("a: 1\x04\nb: 2\n"),
            "e.yaml:1:5: a control character: not a text file, or a damaged one");
}

TEST_F(Reader, ReadsUtf8WithMarkAndCarriageReturns) {
  EXPECT_EQ(parse_yaml("\xEF\xBB\xBF"
                       "a: \xC3\xA9\r\nb: 2\r\n",
                       "e")
                .find("a")
                ->text,
            "\xC3\xA9");
  EXPECT_EQ(complaint("\xEF\xBB\xBF" + blocks), "");
}

TEST_F(Reader, RefusesAnExperimentThatIsNoMapping) {
  EXPECT_EQ(complaint("- a\n"), "e.yaml:1:1: an experiment is a mapping of keys, found a list");
  EXPECT_EQ(complaint("word\n"), "e.yaml:1:1: an experiment is a mapping of keys, found 'word'");
}

}  // namespace
}  // namespace somas::experiment
