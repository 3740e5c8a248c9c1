// Every file that is refused before an experiment runs: which one, why, and what to do about it.
#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/plugins/describe.hpp"
#include "core/plugins/registry.hpp"
#include "tests/docs/generated_part.hpp"

namespace somas::plugins {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path bad = SOMAS_BINARY_DIR "/tests/fixtures/bad";

struct Refused {
  const char* name;
  std::string reason;
};

void PrintTo(const Refused& refused, std::ostream* out) { *out << refused.name; }

class RefusedFile : public testing::TestWithParam<Refused> {};

TEST_P(RefusedFile, IsListedWithReasonAndRemedy) {
  const fs::path directory = bad / GetParam().name;
  const fs::path file = directory / (std::string(GetParam().name) + ".somas.so");
  const Registry found({{directory, "test"}});
  ASSERT_EQ(found.candidates().size(), 1u);
  EXPECT_EQ(found.candidates()[0].library, nullptr);
  EXPECT_EQ(found.candidates()[0].reason, GetParam().reason);
  EXPECT_THAT(listing(found),
              HasSubstr("rejected: " + file.string() + ": " + GetParam().reason + "\n"));
  EXPECT_TRUE(found.ids().empty());
}

const std::string this_host = SOMAS_FINGERPRINT;

const std::vector<Refused> all_refused = {
    Refused{"text",
            "not a shared library (it has no ELF header); build it with "
            "somas_add_plugin"},
    Refused{"truncated",
            "truncated: segment 1 lies beyond the end of the file; copy or build it again"},
    Refused{"wrong_machine",
            "built for another architecture (riscv), this host is x86-64; rebuild it"},
    Refused{"older_abi",
            "built for interface revision 0, this host needs 1: rebuild it with "
            "the SDK of this host"},
    Refused{"newer_abi",
            "built for interface revision 2, this host is older and needs 1: use a "
            "newer SOMAS, or rebuild it with the SDK of this host"},
    Refused{"wrong_fingerprint",
            "built against another SDK: has 'somas-abi 1; another "
            "library', this host needs '" +
                this_host + "': rebuild it"},
    Refused{"no_entry",
            "has no symbol somas_plugin: built without SOMAS_PLUGIN, or not with "
            "somas_add_plugin; rebuild it so"},
    Refused{"undefined",
            "the system's loader refuses it: undefined symbol: "
            "function_that_nobody_defines; build it with somas_add_plugin, which "
            "finds such faults at the link"},
    Refused{"fast_math",
            "changes the floating-point mode of the whole process when loaded "
            "(built with -ffast-math or -Ofast?); rebuild it without"},
    Refused{"wrong_table",
            "its table is unusable: somas_plugin(): is of interface revision 99, "
            "this host needs 1; this is a fault of the plugin"},
    Refused{"throwing",
            "describing its parameters failed: no description today; this is a "
            "fault of the plugin"}};

INSTANTIATE_TEST_SUITE_P(Each, RefusedFile, testing::ValuesIn(all_refused),
                         [](const auto& one) { return std::string(one.param.name); });

TEST(Generated, TableOfRefusedFilesIsUpToDate) {
  std::string table = "| the file | why it is refused, and what to do |\n|---|---|\n";
  for (const Refused& refused : all_refused) {
    std::string name = refused.name;
    std::replace(name.begin(), name.end(), '_', ' ');
    table += "| " + name + " | " + refused.reason + " |\n";
  }
  test::expect_part(SOMAS_SOURCE_DIR "/docs/checking-plugins.md", "refused files", table);
}

}  // namespace
}  // namespace somas::plugins
