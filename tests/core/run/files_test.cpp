#include "core/run/files.hpp"

#include <cerrno>
#include <fcntl.h>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/core/run/scratch.hpp"

namespace somas::run {
namespace {

using test::FullDisk;
using test::Scratch;
using testing::ElementsAre;
using testing::HasSubstr;

class Files : public testing::Test {
 protected:
  std::filesystem::path file() const { return scratch_.path() / "file"; }
  Scratch scratch_;
};

TEST_F(Files, WriteReplacesAndLeavesNothingElse) {
  write_file(file(), "one");
  write_file(file(), "two");
  EXPECT_EQ(read_file(file()), "two");
  EXPECT_THAT(Scratch::names_in(scratch_.path()), ElementsAre("file"));
}

TEST_F(Files, CreateRefusesToReplace) {
  create_file(file(), "one");
  try {
    create_file(file(), "two");
    FAIL() << "no exception";
  } catch (const WriteError& error) {
    EXPECT_EQ(error.error(), EEXIST);
  }
  EXPECT_EQ(read_file(file()), "one");
  EXPECT_THAT(Scratch::names_in(scratch_.path()), ElementsAre("file"));
}

TEST_F(Files, AFullDiskKeepsWhatWasThereAndSaysWhich) {
  write_file(file(), "before");
  try {
    const FullDisk full(100);
    write_file(file(), std::string(1000, 'x'));
    FAIL() << "no exception";
  } catch (const WriteError& error) {
    EXPECT_EQ(error.path(), file());
    EXPECT_EQ(error.error(), EFBIG);
    EXPECT_THAT(error.what(), HasSubstr("cannot write " + file().string() + ": File too large"));
  }
  EXPECT_EQ(read_file(file()), "before");
  EXPECT_THAT(Scratch::names_in(scratch_.path()), ElementsAre("file"));
}

TEST_F(Files, OutputFollowsLinksAndKeepsThem) {
  const std::filesystem::path link = scratch_.path() / "link";
  std::filesystem::create_symlink("file", link);
  write_output(link, "absent");
  EXPECT_EQ(read_file(file()), "absent");
  check_output(link);
  write_output(link, "there");
  EXPECT_EQ(read_file(file()), "there");
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_THAT(Scratch::names_in(scratch_.path()), ElementsAre("file", "link"));
}

TEST_F(Files, OutputGoesStraightIntoAPipe) {
  ASSERT_EQ(::mkfifo(file().c_str(), 0666), 0);
  std::filesystem::create_symlink("file", scratch_.path() / "link");
  check_output(scratch_.path() / "link");
  const int reader = ::open(file().c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_output(scratch_.path() / "link", "through");
  char text[16] = {};
  EXPECT_EQ(::read(reader, text, sizeof text), 7);
  ::close(reader);
  EXPECT_STREQ(text, "through");
  EXPECT_TRUE(std::filesystem::is_fifo(file()));
  EXPECT_THAT(Scratch::names_in(scratch_.path()), ElementsAre("file", "link"));
  EXPECT_THROW(static_cast<void>(read_regular_file(file(), 100)), UsageError);
}

TEST_F(Files, OutputIsCheckedWithoutTouchingWhatIsThere) {
  write_file(file(), "before");
  check_output(file());
  EXPECT_EQ(read_file(file()), "before");
  check_output(scratch_.path() / "new");
  EXPECT_THAT(Scratch::names_in(scratch_.path()), ElementsAre("file"));
  EXPECT_THROW(check_output(scratch_.path()), WriteError);
  EXPECT_THROW(check_output(scratch_.path() / "none" / "x"), WriteError);
  EXPECT_THROW(static_cast<void>(read_regular_file(file(), 5)), UsageError);
}

TEST_F(Files, ADirectoryThatIsMissingIsAWriteError) {
  EXPECT_THROW(write_file(scratch_.path() / "none" / "file", "x"), WriteError);
}

TEST_F(Files, ReadingWhatIsNotThereSaysWhy) {
  try {
    static_cast<void>(read_file(file()));
    FAIL() << "no exception";
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr(file().string() + ": No such file"));
  }
  EXPECT_THROW(static_cast<void>(read_file(scratch_.path())), UsageError);
}

TEST_F(Files, HashIsXxh3Of128Bits) {
  write_file(file(), "");
  EXPECT_EQ(hash_of_file(file()), "99aa06d3014798d86001c324468d497f");
  write_file(file(), "a");
  EXPECT_EQ(hash_of_file(file()), "a96faf705af16834e6c632b61e964e1f");
}

TEST_F(Files, AppendGrowsByPieces) {
  AppendFile log(file(), "head\n");
  log.append("one\n");
  log.append("two\n");
  EXPECT_EQ(read_file(file()), "head\none\ntwo\n");
}

TEST_F(Files, AnAppendFileBeginsAnew) {
  write_file(file(), "of a run that was killed");
  AppendFile log(file(), "head\n");
  log.append("line\n");
  EXPECT_EQ(read_file(file()), "head\nline\n");
}

TEST_F(Files, APieceThatDoesNotFitIsTakenBackWhole) {
  AppendFile log(file(), "head\n");
  log.append(std::string(60, 'a'));
  {
    const FullDisk full(100);
    EXPECT_THROW(log.append(std::string(80, 'b')), WriteError);
  }
  EXPECT_EQ(read_file(file()), "head\n" + std::string(60, 'a'));
  log.append("c");
  EXPECT_EQ(read_file(file()), "head\n" + std::string(60, 'a') + "c");
}

TEST_F(Files, UndoTakesTheLastPieceBack) {
  AppendFile log(file(), "head\n");
  log.append("one\n");
  log.append("two\n");
  log.undo();
  log.append("three\n");
  EXPECT_EQ(read_file(file()), "head\none\nthree\n");
}

}  // namespace
}  // namespace somas::run
