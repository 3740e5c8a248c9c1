#include "core/plugins/services.hpp"

#include <memory>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include "core/plugins/library.hpp"
#include "tests/fixtures/greeting.hpp"

namespace somas::plugins {
namespace {

using testing::HasSubstr;
using testing::Not;

// What plugins say goes to spdlog's default logger.
class Services : public testing::Test {
 protected:
  Services() {
    auto logger = std::make_shared<spdlog::logger>(
        "", std::make_shared<spdlog::sinks::ostream_sink_st>(out_));
    logger->set_pattern("%l: %v");
    spdlog::set_default_logger(std::move(logger));
  }
  ~Services() override { spdlog::set_default_logger(before_); }

  std::string said() const { return out_.str(); }

  static std::shared_ptr<Fitness> talker(std::int64_t words) {
    const auto library =
        Library::open(SOMAS_BINARY_DIR "/tests/fixtures/talker/toy_talker.somas.so");
    const PluginClass described{library, &library->classes()[0]};
    ParameterValue parameters = defaults_of(described.parameters());
    parameters.items[0].integer = words;
    return described.create<Fitness>(parameters);
  }

 private:
  std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
  std::ostringstream out_;
};

TEST_F(Services, PrintWhatALoadedPluginSaysUnderItsName) {
  const auto fitness = talker(2);
  EXPECT_EQ(said(), "warning: somas.test.talker: word 0\nwarning: somas.test.talker: word 1\n");
}

TEST_F(Services, DropAFloodOfMessages) {
  HostServices services("somas.flood");
  Log* log = extension_of<Log>(services);
  ASSERT_NE(log, nullptr);
  for (int i = 0; i < 1000; ++i) log->write(LogLevel::info, "drop " + std::to_string(i));
  EXPECT_THAT(said(), HasSubstr("info: somas.flood: drop 99\nwarning: somas.flood: more than 100 "
                                "messages; further ones are dropped\n"));
  EXPECT_THAT(said(), Not(HasSubstr("drop 100")));
}

TEST_F(Services, TakeLevelsOfALaterSdk) {
  HostServices services("somas.later");
  services.write(static_cast<LogLevel>(77), "text");
  EXPECT_EQ(said(), "info: somas.later: text\n");
}

TEST_F(Services, HaveNoExtensionThatTheyDoNotKnow) {
  const HostServices services("somas.test");
  EXPECT_EQ(services.extension("somas.log/2"), nullptr);
  EXPECT_FALSE(services.version().empty());
}

// The other direction: what a plugin offers beyond its interface.
TEST(Extension, OfAPluginIsFoundByItsId) {
  const auto library = Library::open(SOMAS_BINARY_DIR "/tests/fixtures/talker/toy_talker.somas.so");
  const PluginClass described{library, &library->classes()[0]};
  ParameterValue parameters = defaults_of(described.parameters());
  parameters.items[0].integer = 0;
  const auto fitness = described.create<Fitness>(parameters);
  auto* greeting = extension_of<test::Greeting>(*fitness);
  ASSERT_NE(greeting, nullptr);
  EXPECT_EQ(greeting->greeting(), "hello");
  EXPECT_EQ(fitness->extension("somas.test.greeting/2"), nullptr);
}

TEST(Extension, IsNullWherePluginsKnowNone) {
  const auto library =
      Library::open(SOMAS_BINARY_DIR "/tests/fixtures/plugins/toy_fitness.somas.so");
  const PluginClass described{library, &library->classes()[0]};
  const auto fitness = described.create<Fitness>(defaults_of(described.parameters()));
  EXPECT_EQ(extension_of<test::Greeting>(*fitness), nullptr);
}

}  // namespace
}  // namespace somas::plugins
