#include "core/plugins/library.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/plugins/check.hpp"
#include "core/plugins/registry.hpp"
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace somas::plugins {
namespace {

using testing::HasSubstr;

const std::filesystem::path fixtures = SOMAS_BINARY_DIR "/tests/fixtures";

std::string complaint_of(const std::string& file) {
  try {
    static_cast<void>(Library::open(fixtures / file));
    return "";
  } catch (const BadPlugin& bad) {
    return bad.what();
  }
}

PluginClass toy(const std::string& name) {
  const auto library = Library::open(fixtures / "plugins" / (name + ".somas.so"));
  return {library, &library->classes()[0]};
}

TEST(Library, TellsWhatIsInIt) {
  const auto library = Library::open(fixtures / "plugins/toy_fitness.somas.so");
  EXPECT_EQ(library->id(), "somas.test.fitness");
  EXPECT_EQ(library->version(), "1.0");
  EXPECT_EQ(library->fingerprint(), SOMAS_FINGERPRINT);
  ASSERT_EQ(library->classes().size(), 1u);
  EXPECT_STREQ(library->classes()[0].id, "toy_fitness");
}

TEST(Library, IsLoadedOnce) {
  EXPECT_EQ(Library::open(fixtures / "plugins/toy_fitness.somas.so"),
            Library::open(fixtures / "plugins/../plugins/toy_fitness.somas.so"));
}

TEST(Library, RefusesOneWithoutEntry) {
  EXPECT_EQ(complaint_of("bad/no_entry/no_entry.somas.so"),
            "has no symbol somas_plugin: built without SOMAS_PLUGIN, or not with somas_add_plugin; "
            "rebuild it so");
}

TEST(Library, RefusesAnUndefinedSymbolWhenLoading) {
  EXPECT_THAT(complaint_of("bad/undefined/undefined.somas.so"),
              testing::AllOf(HasSubstr("the system's loader refuses it: "),
                             HasSubstr("function_that_nobody_defines"),
                             testing::Not(HasSubstr("Bad file descriptor"))));
}

TEST(Library, RefusesATableOfAnotherRevision) {
  EXPECT_EQ(
      complaint_of("bad/wrong_table/wrong_table.somas.so"),
      "its table is unusable: somas_plugin(): is of interface revision 99, this host needs 1; "
      "this is a fault of the plugin");
}

TEST(Library, RefusesOneThatCannotDescribeItself) {
  EXPECT_EQ(
      complaint_of("bad/throwing/throwing.somas.so"),
      "describing its parameters failed: no description today; this is a fault of the plugin");
}

#if defined(__SSE__)
TEST(Library, RefusesFastMathAndRestoresTheMode) {
  EXPECT_EQ(complaint_of("bad/fast_math/fast_math.somas.so"),
            "changes the floating-point mode of the whole process when loaded (built with "
            "-ffast-math or -Ofast?); rebuild it without");
  EXPECT_EQ(_mm_getcsr() & 0x8040u, 0u);
}
#endif

TEST(PluginClass, CreatesAnInstanceThatOutlivesIt) {
  std::shared_ptr<Fitness> fitness;
  {
    const PluginClass described = toy("toy_fitness");
    fitness = described.create<Fitness>(defaults_of(described.parameters()));
  }
  EXPECT_EQ(fitness->objective(), "survival");
}

TEST(PluginClass, LetsAConstructorsExceptionPass) {
  const PluginClass described = toy("toy_parameters");
  ParameterValue parameters = defaults_of(described.parameters());
  for (ParameterValue& field : parameters.items)
    if (field.key == "fault") field.text = "construct";
  EXPECT_THROW(static_cast<void>(described.create<Environment>(parameters)), std::runtime_error);
}

// ---- the table
// -----------------------------------------------------------------------------------

class Table : public testing::Test {
 protected:
  Table() {
    parameter_.kind = ParameterKind::number;
    parameter_.name = "rate";
    parameter_.fallback.kind = ParameterKind::number;
    parameter_.minimum = 0;
    class_.id = "toy";
    class_.parameters = &parameter_;
    class_.parameter_count = 1;
    class_.create = [](const Value*) -> void* { return nullptr; };
    class_.destroy = [](void*) {};
    info_.fingerprint = SOMAS_FINGERPRINT;
    info_.id = "test";
    info_.version = "1";
    info_.classes = &class_;
    info_.class_count = 1;
  }
  std::string complaint() const {
    try {
      check_table(&info_);
      return "";
    } catch (const BadPlugin& bad) {
      return bad.what();
    }
  }
  ParameterInfo parameter_;
  ClassInfo class_;
  PluginInfo info_;
};

TEST_F(Table, PassesWhenSound) { EXPECT_EQ(complaint(), ""); }

// A program may bring plugins along in itself.
TEST_F(Table, LinkedInMakesALibraryAndTheOnlyOneOfARegistry) {
  const auto library = Library::linked_in(&info_);
  EXPECT_EQ(library->id(), info_.id);
  EXPECT_EQ(library->fingerprint(), SOMAS_FINGERPRINT);
  EXPECT_EQ(Registry::of(library).ids(), std::vector<std::string>{"toy"});
  class_.id = "Toy";
  EXPECT_THROW(static_cast<void>(Library::linked_in(&info_)), BadPlugin);
}

TEST_F(Table, HasIdsInSnakeCase) {
  class_.id = "Toy";
  EXPECT_THAT(complaint(), HasSubstr("class 0: its id is not in lower_snake_case"));
}

TEST_F(Table, HasDefaultsWithinTheirRange) {
  parameter_.fallback.number = -1;
  EXPECT_THAT(complaint(), HasSubstr("toy.rate: its default -1 is out of its range"));
}

TEST_F(Table, HasNoParameterCalledPlugin) {
  parameter_.name = "plugin";
  EXPECT_THAT(complaint(), HasSubstr("a parameter may not be called 'plugin'"));
}

TEST_F(Table, HasKnownKinds) {
  parameter_.kind = static_cast<ParameterKind>(77);
  EXPECT_THAT(complaint(), HasSubstr("toy.rate: is of unknown kind 77"));
  class_.kind = static_cast<PluginKind>(9);
  EXPECT_THAT(complaint(), HasSubstr("toy: is of unknown kind 9"));
}

TEST_F(Table, HasThisHostsSizes) {
  parameter_.size = 8;
  EXPECT_THAT(complaint(), HasSubstr("toy.rate: its size is that of another SDK"));
}

TEST_F(Table, HasDistinctNames) {
  const ParameterInfo twice[] = {parameter_, parameter_};
  class_.parameters = twice;
  class_.parameter_count = 2;
  EXPECT_THAT(complaint(), HasSubstr("two parameters are called 'rate'"));
}

}  // namespace
}  // namespace somas::plugins
