#include "core/plugins/elf.hpp"

#include <cstddef>
#include <elf.h>
#include <fstream>
#include <iterator>
#include <random>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>

#include "somas/sdk/abi.hpp"

namespace somas::plugins {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::filesystem::path fixtures = SOMAS_BINARY_DIR "/tests/fixtures";

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Elf : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(directory_); }

  // Why a file with these bytes is refused; empty when it is not.
  std::string complaint(const std::string& bytes) {
    const std::filesystem::path file = directory_ / "x.somas.so";
    std::ofstream(file, std::ios::binary) << bytes;
    return complaint_of(file);
  }
  static std::string complaint_of(const std::filesystem::path& file) {
    try {
      static_cast<void>(read_fingerprint(file));
      return "";
    } catch (const BadPlugin& bad) {
      return bad.what();
    }
  }

  template <class T>
  static void patch(std::string& bytes, std::size_t offset, T value) {
    bytes.replace(offset, sizeof value, reinterpret_cast<const char*>(&value), sizeof value);
  }

  std::filesystem::path directory_ = [] {
    std::string name = testing::TempDir() + "somas_elf_XXXXXX";
    return std::filesystem::path(::mkdtemp(name.data()));
  }();
  std::string good_ = bytes_of(fixtures / "plugins/toy_fitness.somas.so");
};

TEST_F(Elf, ReadsTheFingerprintOfAPlugin) {
  EXPECT_EQ(read_fingerprint(fixtures / "plugins/toy_fitness.somas.so"), SOMAS_FINGERPRINT);
  EXPECT_NO_THROW(check_fingerprint(SOMAS_FINGERPRINT));
}

TEST_F(Elf, SaysThatAFileIsNoLibrary) {
  EXPECT_EQ(complaint("This is no library."),
            "not a shared library (it has no ELF header); build it with somas_add_plugin");
  EXPECT_EQ(complaint(""), "an empty file; build it again");
  EXPECT_EQ(complaint_of(directory_), "a directory, not a file");
  EXPECT_EQ(complaint_of(directory_ / "none"), "no such file");
  EXPECT_EQ(complaint_of("/dev/null"), "not a regular file");
}

TEST_F(Elf, SaysForWhatMachineItWasBuilt) {
  std::string other = good_;
  patch(other, offsetof(Elf64_Ehdr, e_machine), static_cast<Elf64_Half>(EM_RISCV));
  EXPECT_THAT(complaint(other),
              StartsWith("built for another architecture (riscv), this host is "));
  other = good_;
  other[EI_CLASS] = ELFCLASS32;
  EXPECT_EQ(complaint(other), "built for a 32-bit machine; rebuild it");
  other = good_;
  other[EI_DATA] = ELFDATA2MSB;
  EXPECT_EQ(complaint(other), "built for a big-endian machine; rebuild it");
}

TEST_F(Elf, SaysThatAnObjectFileIsNoLibrary) {
  std::string object = good_;
  patch(object, offsetof(Elf64_Ehdr, e_type), static_cast<Elf64_Half>(ET_REL));
  EXPECT_EQ(complaint(object),
            "not a shared library, but an object file; build it with somas_add_plugin");
}

TEST_F(Elf, SaysThatALibraryIsNoPlugin) {
  const char* libc_like = "/lib/x86_64-linux-gnu/libm.so.6";
  if (!std::filesystem::exists(libc_like)) GTEST_SKIP();
  EXPECT_EQ(complaint_of(libc_like),
            "no SOMAS note: not a plugin, or built without SOMAS_PLUGIN; name it otherwise, or "
            "rebuild it so");
}

TEST_F(Elf, ComparesTheFingerprint) {
  const std::string other =
      read_fingerprint(fixtures / "bad/wrong_fingerprint" / "wrong_fingerprint.somas.so");
  try {
    check_fingerprint(other);
    FAIL();
  } catch (const BadPlugin& bad) {
    EXPECT_EQ(std::string(bad.what()),
              "built against another SDK: has 'somas-abi 1; another library', this host needs "
              "'" SOMAS_FINGERPRINT "': rebuild it");
  }
}

TEST_F(Elf, RefusesEveryTruncation) {
  for (std::size_t length = 64; length < good_.size(); length += 997)
    ASSERT_THAT(complaint(good_.substr(0, length)), StartsWith("truncated: ")) << length;
  EXPECT_THAT(complaint(good_.substr(0, 40)), StartsWith("truncated: the ELF header"));
  EXPECT_THAT(complaint(good_.substr(0, good_.size() - 1)), StartsWith("truncated: "));
}

TEST_F(Elf, RefusesADamagedNote) {
  std::string damaged = good_;
  const std::size_t note = damaged.find(std::string("SOMAS\0\0\0", 8) + "somas-abi");
  ASSERT_NE(note, std::string::npos);
  damaged[note] = 'X';
  EXPECT_EQ(complaint(damaged), "its SOMAS note is damaged; build it again");
}

TEST_F(Elf, SurvivesAnyDamageToItsHeaders) {
  std::mt19937 random(1);
  Elf64_Ehdr header;
  good_.copy(reinterpret_cast<char*>(&header), sizeof header);
  for (int i = 0; i < 400; ++i) {
    std::string damaged = good_;
    const bool in_sections = random() % 2 == 0;
    const std::size_t at = in_sections ? header.e_shoff + random() % (header.e_shnum * 64u)
                                       : random() % (64 + header.e_phnum * 56u);
    damaged[at] = static_cast<char>(random());
    static_cast<void>(complaint(damaged));
  }
}

/// All that is read of a file before it is loaded.
void read_all(const std::filesystem::path& file) {
  try {
    check_fingerprint(read_fingerprint(file));
    static_cast<void>(imported_functions(file));
  } catch (const BadPlugin& bad) {
    ASSERT_FALSE(std::string(bad.what()).empty());
  }
}

// Anything but BadPlugin, a crash or a read beyond the end is a failure. The file is the one that
// is kept in the tree, so that the damage is the same everywhere.
TEST_F(Elf, SurvivesThousandsOfFlippedBytesAndCuts) {
  const std::string whole = bytes_of(SOMAS_SOURCE_DIR "/tests/fixtures/abi1/abi1.somas.so");
  Elf64_Ehdr header;
  ASSERT_EQ(whole.copy(reinterpret_cast<char*>(&header), sizeof header), sizeof header);
  const std::size_t note = whole.find(std::string("SOMAS\0\0\0", 8));
  // What is worth damaging: the headers, the note, the table of symbols; then anything.
  const std::pair<std::size_t, std::size_t> regions[] = {
      {0, 64 + header.e_phnum * sizeof(Elf64_Phdr)},
      {header.e_shoff, header.e_shnum * sizeof(Elf64_Shdr)},
      {note - 12, sizeof(PluginNote)},
      {0, 4096},
      {0, whole.size()}};
  // In memory: a disk would take longer than the reading.
  const int memory = ::memfd_create("x.somas.so", MFD_CLOEXEC);
  ASSERT_GE(memory, 0);
  const std::filesystem::path file = "/proc/self/fd/" + std::to_string(memory);
  std::mt19937 random(7);
  for (int i = 0; i < 4000; ++i) {
    std::string damaged = whole;
    const auto& [first, length] = regions[random() % std::size(regions)];
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips) {
      const std::size_t at = first + random() % length;
      // Extremes reach further than chance does.
      constexpr unsigned char extremes[] = {0x00, 0x01, 0x7F, 0x80, 0xFF};
      damaged[at] = static_cast<char>(random() % 2 == 0 ? extremes[random() % 5] : random());
    }
    if (random() % 8 == 0) damaged.resize(random() % damaged.size());
    ASSERT_EQ(::ftruncate(memory, 0), 0);
    ASSERT_EQ(::pwrite(memory, damaged.data(), damaged.size(), 0),
              static_cast<ssize_t>(damaged.size()));
    ASSERT_NO_FATAL_FAILURE(read_all(file)) << i;
  }
  ::close(memory);
}

TEST_F(Elf, ListsWhatALibraryTakesFromOthers) {
  const std::vector<std::string> names =
      imported_functions(fixtures / "bad/undocumented/undocumented.somas.so");
  EXPECT_THAT(names, testing::Contains("exp"));
  EXPECT_THAT(names, testing::Not(testing::Contains("somas_plugin")));
}

}  // namespace
}  // namespace somas::plugins
