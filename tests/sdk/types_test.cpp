// Keys, matrices, grids and the plugin table.
#include "somas/sdk/types.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include "somas/sdk/plugin.hpp"

namespace somas {
namespace {

TEST(StableKey, IsFnv1a) {
  // Published test vectors of 64-bit FNV-1a.
  EXPECT_EQ(stable_key(""), 0xcbf29ce484222325ull);
  EXPECT_EQ(stable_key("a"), 0xaf63dc4c8601ec8cull);
  EXPECT_EQ(stable_key("foobar"), 0x85944171f73967e8ull);
  static_assert(stable_key("b") == 0xaf63df4c8601f1a5ull);
}

TEST(StableKey, DependsOnItsSeed) {
  EXPECT_NE(stable_key("energy", 1), stable_key("energy", 2));
  EXPECT_NE(stable_key("energy", 1), stable_key("pressure", 1));
}

TEST(MatrixView, ChannelsAreStrided) {
  std::vector<float> data(20);
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<float>(i);
  const Matrix<float> m{data.data() + 1, 3, 4, 6};
  EXPECT_EQ(m.channel(0).size(), 4u);
  EXPECT_EQ(m.channel(0)[0], 1);
  EXPECT_EQ(m.channel(2)[3], 16);
  m.channel(1)[2] = -1;
  EXPECT_EQ(data[9], -1);
}

TEST(GridView, FindsTheSquareThatHoldsAPoint) {
  std::vector<double> values(6);
  const Grid grid{values, {.columns = 3, .rows = 2, .side = 2, .left = -1, .bottom = 5}};
  EXPECT_EQ(grid.index_of(-1, 5), 0) << "lower and left edges belong to a square";
  EXPECT_EQ(grid.index_of(0.99, 6.99), 0);
  EXPECT_EQ(grid.index_of(1, 5), 1);
  EXPECT_EQ(grid.index_of(4.99, 8.99), 5);
  EXPECT_EQ(grid.index_of(0, 7), 3) << "row-major from the lower left";
  for (const auto& [x, y] : {std::pair(-1.01, 6.0), std::pair(5.0, 6.0), std::pair(0.0, 4.99),
                             std::pair(0.0, 9.0), std::pair(1e300, 6.0)})
    EXPECT_EQ(grid.index_of(x, y), -1) << x << ' ' << y;
  EXPECT_EQ(grid.index_of(std::numeric_limits<double>::quiet_NaN(), 6), -1);
  EXPECT_EQ(grid.centre_x(5), 4);
  EXPECT_EQ(grid.centre_y(5), 8);
  EXPECT_EQ(grid.centre_x(3), 0);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(grid.index_of(grid.centre_x(i), grid.centre_y(i)), static_cast<std::int64_t>(i));
}

TEST(Errors, ParameterErrorCarriesItsPath) {
  const ParameterError error("states[2].parent", "is nobody");
  EXPECT_EQ(error.path(), "states[2].parent");
  EXPECT_STREQ(error.what(), "is nobody");
}

// ---- the plugin table ---------------------------------------------------------------------------

int living = 0;

class Breeze final : public Environment {
 public:
  static constexpr About about{"breeze", "A constant force"};
  struct Parameters {
    double strength = 0.25;
    void describe(Describe& d) { d("strength", strength, "Force along x"); }
  };
  explicit Breeze(const Parameters& p) : strength(p.strength) { ++living; }
  ~Breeze() override { --living; }
  Breeze(const Breeze&) = delete;
  Breeze& operator=(const Breeze&) = delete;
  void declare(Declare& d) override { d.acts_in(Phase::forces); }
  void act(Phase, World&) const override {}
  double strength;
};

class Longevity final : public Fitness {
 public:
  static constexpr About about{"longevity", "How long"};
  struct Parameters {
    void describe(Describe&) {}
  };
  explicit Longevity(const Parameters&) {}
  [[nodiscard]] std::string_view objective() const override { return "survival"; }
  [[nodiscard]] double score(const Outcome&) const override { return 1; }
};

TEST(PluginTable, ListsItsClasses) {
  const PluginInfo& info = *detail::plugin_info<Breeze, Longevity>("example.weather", "1.2");
  EXPECT_EQ(info.size, sizeof(PluginInfo));
  EXPECT_EQ(info.abi, std::uint32_t{SOMAS_ABI_REVISION});
  EXPECT_STREQ(info.fingerprint, SOMAS_FINGERPRINT);
  EXPECT_STREQ(info.id, "example.weather");
  EXPECT_STREQ(info.version, "1.2");
  ASSERT_EQ(info.class_count, 2u);
  EXPECT_EQ(info.classes[0].kind, PluginKind::environment);
  EXPECT_STREQ(info.classes[0].id, "breeze");
  EXPECT_STREQ(info.classes[0].doc, "A constant force");
  ASSERT_EQ(info.classes[0].parameter_count, 1u);
  EXPECT_STREQ(info.classes[0].parameters[0].name, "strength");
  EXPECT_EQ(info.classes[0].parameters[0].fallback.number, 0.25);
  EXPECT_EQ(info.classes[1].kind, PluginKind::fitness);
  EXPECT_EQ(info.classes[1].parameter_count, 0u);
}

TEST(PluginTable, CreatesFromValuesAndDestroys) {
  const PluginInfo& info = *detail::plugin_info<Breeze, Longevity>("example.weather", "1.2");
  Value strength;
  strength.kind = ParameterKind::number;
  strength.number = 3.5;
  strength.key = "strength";
  Value group;
  group.kind = ParameterKind::group;
  group.items = &strength;
  group.count = 1;
  void* made = info.classes[0].create(&group);
  EXPECT_EQ(living, 1);
  auto* environment = static_cast<Environment*>(made);
  auto* breeze = dynamic_cast<Breeze*>(environment);
  ASSERT_NE(breeze, nullptr);
  EXPECT_EQ(breeze->strength, 3.5);
  info.classes[0].destroy(made);
  EXPECT_EQ(living, 0);
}

TEST(PluginTable, BoundaryTypesArePlainData) {
  static_assert(std::is_standard_layout_v<Value> && std::is_trivially_copyable_v<Value>);
  static_assert(std::is_standard_layout_v<ParameterInfo>);
  static_assert(std::is_standard_layout_v<ClassInfo>);
  static_assert(std::is_standard_layout_v<PluginInfo>);
  const PluginNote note;
  EXPECT_STREQ(note.name, "SOMAS");
  EXPECT_EQ(note.name_size, sizeof "SOMAS");
  EXPECT_EQ(note.description_size, sizeof note.description);
  EXPECT_STREQ(note.description, SOMAS_FINGERPRINT);
  EXPECT_LT(std::string(SOMAS_FINGERPRINT).size(), sizeof note.description);
}

}  // namespace
}  // namespace somas
